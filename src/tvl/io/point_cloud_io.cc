#include "tvl/io/point_cloud_io.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <ostream>
#include <sstream>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/atomic_file.h"

namespace tvl {
namespace {

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "The formats are little endian, and so is every platform this is built for."
#endif

constexpr size_t kChunkPoints = 65536;  // written at once

// What a header says of the records behind it.
struct Header {
  size_t points = 0;
  std::vector<std::string> fields;
};

void CheckCloud(const MapCloud& cloud) {
  TVL_CHECK(cloud.points.size() == cloud.intensity.size())
      << cloud.points.size() << " points, " << cloud.intensity.size() << " intensities";
}

void WriteRecords(const MapCloud& cloud, std::ostream& out) {
  std::vector<float> chunk;
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    chunk.insert(chunk.end(), {p.x(), p.y(), p.z(), cloud.intensity[i]});
    if (chunk.size() < 4 * kChunkPoints && i + 1 < cloud.points.size()) continue;
    out.write(reinterpret_cast<const char*>(chunk.data()),
              static_cast<std::streamsize>(chunk.size() * sizeof(float)));
    chunk.clear();
  }
}

MapCloud ReadRecords(const Header& header, const std::string& path, std::istream& in) {
  const bool has_intensity = header.fields == std::vector<std::string>{"x", "y", "z", "intensity"};
  TVL_CHECK_INPUT(has_intensity || header.fields == std::vector<std::string>({"x", "y", "z"}))
      << path << ": want the fields x y z [intensity]";
  const size_t width = header.fields.size();
  MapCloud cloud;
  std::array<float, 4> v{};
  for (size_t i = 0; i < header.points; ++i) {
    in.read(reinterpret_cast<char*>(v.data()), static_cast<std::streamsize>(width * sizeof(float)));
    TVL_CHECK_INPUT(in.good()) << path << ": cut off after " << i << " points of " << header.points;
    cloud.points.emplace_back(v[0], v[1], v[2]);
    cloud.intensity.push_back(has_intensity ? v[3] : 0.0F);
  }
  return cloud;
}

size_t ParseCount(const std::string& word, const std::string& path) {
  const bool is_count = !word.empty() && word.size() < 18 &&
                        word.find_first_not_of("0123456789") == std::string::npos;
  TVL_CHECK_INPUT(is_count) << path << ": not a number of points: `" << word << "`";
  return std::stoull(word);
}

std::ifstream OpenBinary(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  TVL_CHECK_INPUT(in.good()) << path << ": cannot be read";
  return in;
}

Header ReadPcdHeader(const std::string& path, std::istream& in) {
  Header header;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key, word;
    words >> key;
    if (key == "FIELDS") {
      while (words >> word) header.fields.push_back(word);
    } else if (key == "SIZE" || key == "TYPE") {
      while (words >> word) {
        TVL_CHECK_INPUT(word == "4" || word == "F") << path << ": want float32 fields";
      }
    } else if (key == "POINTS") {
      words >> word;
      header.points = ParseCount(word, path);
    } else if (key == "DATA") {
      words >> word;
      TVL_CHECK_INPUT(word == "binary") << path << ": want DATA binary, is " << word;
      return header;
    }
  }
  throw InputError(path + ": not a PCD file");
}

Header ReadPlyHeader(const std::string& path, std::istream& in) {
  Header header;
  std::string line;
  std::getline(in, line);
  TVL_CHECK_INPUT(line == "ply") << path << ": not a PLY file";
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key, a, b;
    words >> key >> a >> b;
    if (key == "end_header") return header;
    if (key == "format") {
      TVL_CHECK_INPUT(a == "binary_little_endian") << path << ": want binary_little_endian";
    } else if (key == "element") {
      TVL_CHECK_INPUT(a == "vertex") << path << ": want vertices only, has " << a;
      header.points = ParseCount(b, path);
    } else if (key == "property") {
      TVL_CHECK_INPUT(a == "float") << path << ": want float properties, has " << a;
      header.fields.push_back(b);
    }
  }
  throw InputError(path + ": the header has no end");
}

}  // namespace

void WritePcd(const std::string& path, const MapCloud& cloud) {
  CheckCloud(cloud);
  const size_t n = cloud.points.size();
  WriteAtomically(path, [&](std::ostream& out) {
    out << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
        << "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " << n << "\nHEIGHT 1\n"
        << "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << n << "\nDATA binary\n";
    WriteRecords(cloud, out);
  });
}

void WritePly(const std::string& path, const MapCloud& cloud) {
  CheckCloud(cloud);
  WriteAtomically(path, [&](std::ostream& out) {
    out << "ply\nformat binary_little_endian 1.0\ncomment world frame, metres\nelement vertex "
        << cloud.points.size() << "\nproperty float x\nproperty float y\nproperty float z\n"
        << "property float intensity\nend_header\n";
    WriteRecords(cloud, out);
  });
}

MapCloud ReadPcd(const std::string& path) {
  std::ifstream in = OpenBinary(path);
  const Header header = ReadPcdHeader(path, in);
  return ReadRecords(header, path, in);
}

MapCloud ReadPly(const std::string& path) {
  std::ifstream in = OpenBinary(path);
  const Header header = ReadPlyHeader(path, in);
  return ReadRecords(header, path, in);
}

}  // namespace tvl
