#include "tvl/io/cloud/las.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Between 4096 and 8192 neighbouring float32 numbers are 0.5 mm apart, beyond it 1 mm.
constexpr double kMostExact_m = 8192.0;
constexpr size_t kIntensityOffset = 12;

// Bytes of the fields that each point format begins with, and where its GPS time is (0: none).
struct PointFormat {
  size_t bytes, gps_time_offset;
};
constexpr std::array<PointFormat, 11> kFormats = {{{20, 0},
                                                   {28, 20},
                                                   {26, 0},
                                                   {34, 20},
                                                   {57, 20},
                                                   {63, 20},
                                                   {30, 22},
                                                   {36, 22},
                                                   {38, 22},
                                                   {59, 22},
                                                   {67, 22}}};

struct Header {
  size_t data_offset = 0;  // of the first point
  size_t point_bytes = 0;  // from one point to the next
  size_t points = 0;
  PointFormat format{};
  Eigen::Vector3d scale, offset;  // x = number * scale + offset
};

Eigen::Vector3d Vector3At(const uint8_t* data, size_t bytes, size_t at, const std::string& source) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) {
    v[i] = LittleDoubleAt(data, bytes, at + 8 * static_cast<size_t>(i), source);
  }
  return v;
}

// The least size of the header of version 1.`minor`.
size_t HeaderBytes(int minor) {
  if (minor <= 2) return 227;
  return minor == 3 ? 235 : 375;
}

PointFormat FormatOf(uint8_t byte, const std::string& source) {
  TVL_CHECK_INPUT((byte & 0xC0) == 0)
      << source
      << ": byte 104: the points are compressed (LAZ), which is not read: unpack the file "
      << "first, e.g. `las2las -i in.laz -o out.las` or `pdal translate in.laz out.las`";
  TVL_CHECK_INPUT(byte < kFormats.size())
      << source << ": byte 104: point format " << static_cast<int>(byte) << ", known are 0 to 10";
  return kFormats[byte];
}

// Version 1.4 counts with 64 bits and leaves the older number 0 where it does not fit.
size_t PointCount(const uint8_t* data, size_t bytes, int minor, const std::string& source) {
  const size_t legacy = LittleUint32At(data, bytes, 107, source);
  if (minor < 4) return legacy;
  const size_t points = LittleUint64At(data, bytes, 247, source);
  return points == 0 ? legacy : points;
}

Header ReadHeader(const uint8_t* data, size_t bytes, const std::string& source) {
  TVL_CHECK_INPUT(bytes >= 4 && std::memcmp(data, "LASF", 4) == 0)
      << source << ": byte 0: want LASF: not a LAS file";
  TVL_CHECK_INPUT(bytes >= HeaderBytes(0))
      << source << ": " << bytes << " bytes, the header alone has " << HeaderBytes(0);
  const int major = data[24], minor = data[25];
  TVL_CHECK_INPUT(major == 1 && minor <= 4)
      << source << ": byte 24: version " << major << "." << minor << ", known are 1.0 to 1.4";
  Header header;
  header.format = FormatOf(data[104], source);
  header.data_offset = LittleUint32At(data, bytes, 96, source);
  const size_t header_bytes = LittleUint16At(data, bytes, 94, source);
  TVL_CHECK_INPUT(header_bytes >= HeaderBytes(minor) && header_bytes <= header.data_offset &&
                  header.data_offset <= bytes)
      << source << ": byte 94: a header of " << header_bytes << " bytes and points from byte "
      << header.data_offset << " in a file of " << bytes << " bytes (version 1." << minor << ")";
  header.point_bytes = LittleUint16At(data, bytes, 105, source);
  TVL_CHECK_INPUT(header.point_bytes >= header.format.bytes)
      << source << ": byte 105: points of " << header.point_bytes << " bytes, point format "
      << static_cast<int>(data[104]) << " has at least " << header.format.bytes;
  header.points = PointCount(data, bytes, minor, source);
  const size_t fit = (bytes - header.data_offset) / header.point_bytes;
  TVL_CHECK_INPUT(header.points <= fit)
      << source << ": " << header.points << " points are announced, " << fit << " fit into the "
      << bytes - header.data_offset << " bytes from byte " << header.data_offset << ": cut off?";
  TVL_CHECK_INPUT(header.points <= kMostPoints)
      << source << ": " << header.points << " points: more than any scan has (" << kMostPoints
      << ")";
  header.scale = Vector3At(data, bytes, 131, source);
  header.offset = Vector3At(data, bytes, 155, source);
  TVL_CHECK_INPUT(header.scale.allFinite() && header.offset.allFinite() &&
                  header.scale.cwiseAbs().minCoeff() > 0.0)
      << source << ": byte 131: scales and offsets must be numbers, and scales not 0";
  return header;
}

// The whole numbers of point i, before scale and offset.
Eigen::Vector3d StoredPoint(const Header& header, const uint8_t* data, size_t i) {
  std::array<int32_t, 3> numbers;
  std::memcpy(numbers.data(), data + header.data_offset + i * header.point_bytes, sizeof(numbers));
  return {static_cast<double>(numbers[0]), static_cast<double>(numbers[1]),
          static_cast<double>(numbers[2])};
}

// What is subtracted from all points: zero, the header's offset or the first point.
Eigen::Vector3d ChooseOrigin(const Header& header, const uint8_t* data,
                             std::vector<std::string>* notes) {
  if (header.points == 0) return Eigen::Vector3d::Zero();
  Eigen::Vector3d least = StoredPoint(header, data, 0), most = least;
  for (size_t i = 1; i < header.points; ++i) {
    const Eigen::Vector3d stored = StoredPoint(header, data, i);
    least = least.cwiseMin(stored), most = most.cwiseMax(stored);
  }
  const auto reach_m = [&](const Eigen::Vector3d& origin) {
    const Eigen::Vector3d a = least.cwiseProduct(header.scale) + (header.offset - origin);
    const Eigen::Vector3d b = most.cwiseProduct(header.scale) + (header.offset - origin);
    return a.cwiseAbs().cwiseMax(b.cwiseAbs()).maxCoeff();
  };
  if (reach_m(Eigen::Vector3d::Zero()) <= kMostExact_m) return Eigen::Vector3d::Zero();
  Eigen::Vector3d origin = header.offset;
  std::string what = "the header's offset";
  if (reach_m(origin) > kMostExact_m) {
    origin += StoredPoint(header, data, 0).cwiseProduct(header.scale);
    what = "the first point";
  }
  std::ostringstream note;
  note << std::fixed << std::setprecision(3) << "coordinates are relative to " << what << " ("
       << origin.x() << ", " << origin.y() << ", " << origin.z()
       << "): as stored they are too large for float32 to keep 1 mm";
  if (reach_m(origin) > kMostExact_m) note << ", and the farthest still are";
  notes->push_back(note.str());
  return origin;
}

void ReadPoints(const Header& header, const uint8_t* data, const Eigen::Vector3d& origin,
                RawScan* scan) {
  const Eigen::Vector3d shift = header.offset - origin;
  scan->points.reserve(header.points);
  scan->intensity.reserve(header.points);
  for (size_t i = 0; i < header.points; ++i) {
    const Eigen::Vector3d p = StoredPoint(header, data, i).cwiseProduct(header.scale) + shift;
    scan->points.push_back(p.cast<float>());
    const uint8_t* intensity =
        data + header.data_offset + i * header.point_bytes + kIntensityOffset;
    scan->intensity.push_back(static_cast<float>(NumberAt(intensity, NumberType::kUint16, false)));
  }
  scan->intensity_field = "intensity";
  scan->width = header.points;
}

void ReadTimes(const Header& header, const uint8_t* data, RawScan* scan) {
  if (header.format.gps_time_offset == 0) return;
  scan->time.reserve(header.points);
  for (size_t i = 0; i < header.points; ++i) {
    const uint8_t* time =
        data + header.data_offset + i * header.point_bytes + header.format.gps_time_offset;
    scan->time.push_back(NumberAt(time, NumberType::kFloat64, false));
    if (!std::isfinite(scan->time.back())) return scan->time.clear();  // as DecodePoints does
  }
  scan->time_field = "gps_time";
}

}  // namespace

CloudRead ParseLas(const uint8_t* data, size_t bytes, const std::string& source) {
  const Header header = ReadHeader(data, bytes, source);
  CloudRead read;
  const Eigen::Vector3d origin = ChooseOrigin(header, data, &read.notes);
  ReadPoints(header, data, origin, &read.scan);
  ReadTimes(header, data, &read.scan);
  return read;
}

CloudRead ReadLasScan(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadFileBytes(path);
  return ParseLas(bytes.data(), bytes.size(), path);
}

}  // namespace tvl
