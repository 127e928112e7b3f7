#include "tvl/io/cloud/cloud_read.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include "tvl/base/check.h"

namespace tvl {
namespace {

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Numbers are copied as they are: this is written for little-endian platforms."
#endif

template <typename T>
T LittleAt(const uint8_t* data, size_t bytes, size_t offset, const std::string& source) {
  TVL_CHECK_INPUT(offset <= bytes && sizeof(T) <= bytes - offset)
      << source << ": byte " << offset << ": want " << sizeof(T) << " bytes, the file has " << bytes
      << " in all: cut off?";
  T value;
  std::memcpy(&value, data + offset, sizeof(T));
  return value;
}

}  // namespace

std::vector<uint8_t> ReadFileBytes(const std::string& path) {
  std::error_code ignored;
  TVL_CHECK_INPUT(std::filesystem::is_regular_file(path, ignored)) << path << ": no such file";
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  TVL_CHECK_INPUT(file.good()) << path << ": cannot be read";
  const std::streamoff size = file.tellg();
  TVL_CHECK_INPUT(size >= 0 && static_cast<size_t>(size) <= kMostCloudBytes)
      << path << ": " << size << " bytes: more than any scan has (" << kMostCloudBytes << ")";
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  TVL_CHECK_INPUT(file.gcount() == size)
      << path << ": cannot be read beyond byte " << file.gcount();
  return bytes;
}

uint16_t LittleUint16At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source) {
  return LittleAt<uint16_t>(data, bytes, offset, source);
}

uint32_t LittleUint32At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source) {
  return LittleAt<uint32_t>(data, bytes, offset, source);
}

uint64_t LittleUint64At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source) {
  return LittleAt<uint64_t>(data, bytes, offset, source);
}

double LittleDoubleAt(const uint8_t* data, size_t bytes, size_t offset, const std::string& source) {
  return LittleAt<double>(data, bytes, offset, source);
}

PointTable TableOfNumbers(const std::vector<std::string>& names, const std::vector<double>& numbers,
                          size_t width, size_t height, const std::string& source) {
  PointTable table;
  for (size_t i = 0; i < names.size(); ++i) {
    table.fields.push_back({names[i], i * sizeof(double), NumberType::kFloat64, 1});
  }
  table.width = width, table.height = height;
  table.point_step = names.size() * sizeof(double);
  const size_t points = names.empty() ? 0 : numbers.size() / names.size();
  // The division keeps the product from overflowing.
  TVL_CHECK_INPUT((width == 0 || height <= points / width) && width * height == points)
      << source << ": " << width << " x " << height << " points are announced, " << points
      << " are there";
  table.row_step = width * table.point_step;
  table.data = reinterpret_cast<const uint8_t*>(numbers.data());
  table.bytes = numbers.size() * sizeof(double);
  return table;
}

}  // namespace tvl
