#include "tvl/io/velodyne_bin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "tvl/base/units.h"
#include "tvl/io/atomic_file.h"

namespace tvl {
namespace {

constexpr size_t kPointBytes = 4 * sizeof(float);
constexpr std::streamoff kMostBytes = 1 << 28;  // 16 million points
constexpr float kMaxCoordinate_m = 1e4F;        // no lidar sees further: such bytes are garbage

using Kind = FrameFault::Kind;

// Nothing of what is not a file, such as a folder of that name, or larger than any scan.
std::optional<std::vector<char>> ReadBytes(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file.good()) return std::nullopt;
  const std::streamoff size = file.tellg();
  if (size < 0 || size > kMostBytes) return std::nullopt;
  std::vector<char> bytes(static_cast<size_t>(size));
  file.seekg(0);
  file.read(bytes.data(), size);
  if (file.gcount() != size) return std::nullopt;
  return bytes;
}

// The usable points of whole records.
LidarScan Decode(const std::vector<char>& bytes) {
  const size_t n = bytes.size() / kPointBytes;
  LidarScan scan;
  scan.points.reserve(n);
  scan.intensity.reserve(n);
  for (size_t i = 0; i < n; ++i) {
    std::array<float, 4> v;
    std::memcpy(v.data(), bytes.data() + i * kPointBytes, kPointBytes);
    const Eigen::Vector3f p(v[0], v[1], v[2]);
    // Written so that NaN fails.
    if (!(p.cwiseAbs().maxCoeff() < kMaxCoordinate_m) || !p.allFinite()) continue;
    scan.points.push_back(p);
    scan.intensity.push_back(std::isfinite(v[3]) ? v[3] : 0.0F);
  }
  return scan;
}

// Median elevation of the last points with a return, rad.
double EndElevation_rad(const LidarScan& scan) {
  constexpr size_t kPoints = 100;
  constexpr float kNoReturn_m = 0.1F;  // files may be filled up with zeros
  std::vector<float> elevations_rad;
  for (size_t i = scan.size(); i > 0 && elevations_rad.size() < kPoints; --i) {
    const Eigen::Vector3f& p = scan.points[i - 1];
    if (p.norm() > kNoReturn_m) elevations_rad.push_back(std::atan2(p.z(), p.head<2>().norm()));
  }
  if (elevations_rad.empty()) return 0.0;
  const auto middle =
      elevations_rad.begin() + static_cast<std::ptrdiff_t>(elevations_rad.size() / 2);
  std::nth_element(elevations_rad.begin(), middle, elevations_rad.end());
  return static_cast<double>(*middle);
}

// What is missing of the scan, or empty.
std::string Truncation(const LidarScan& scan, int turns, const ScanExpectation& expected) {
  std::ostringstream out;
  if (turns + 1 < expected.min_ring_share * expected.rings) {
    out << "only " << turns + 1 << " rings of " << expected.rings << " (" << scan.size()
        << " points): cut off, not stored ring after ring, or another sensor than the profile's "
           "(--profile)";
  } else if (static_cast<double>(scan.size()) <
             expected.min_point_share * static_cast<double>(expected.typical_points)) {
    out << "only " << scan.size() << " points, " << expected.typical_points
        << " are typical here: cut off";
  } else if (expected.rings > 0) {
    const double above_rad = EndElevation_rad(scan) - expected.lowest_beam_rad;
    if (above_rad > expected.max_end_above_rad) {
      out << "ends " << RadToDeg(above_rad) << " deg above the lowest beam: cut off";
    }
  }
  return out.str();
}

}  // namespace

int CountAzimuthTurns(const std::vector<Eigen::Vector3f>& points) {
  // Winding number about the z axis: signed crossings of the half plane y = 0, x > 0.
  int turns = 0;
  size_t last = 0;
  for (size_t i = 1; i < points.size(); ++i) {
    if (points[i].isZero()) continue;  // no return
    const Eigen::Vector3f& a = points[last];
    const Eigen::Vector3f& b = points[i];
    last = i;
    const bool a_left = a.y() >= 0.0F, b_left = b.y() >= 0.0F;
    if (a_left == b_left) continue;
    const float cross = a.x() * b.y() - a.y() * b.x();
    if (!a_left && cross > 0.0F) ++turns;
    if (a_left && cross < 0.0F) --turns;
  }
  return std::abs(turns);
}

ScanExpectation ExpectationFor(const LidarModel& lidar, size_t typical_points) {
  ScanExpectation expected;
  expected.typical_points = typical_points;
  expected.rings = lidar.rows();
  if (expected.rings > 0) expected.lowest_beam_rad = lidar.beam_elevation_rad.back();
  return expected;
}

ScanRead ReadVelodyneBin(const std::string& path, const ScanExpectation& expected) {
  ScanRead read;
  const auto bytes = ReadBytes(path);
  if (!bytes) {
    read.faults.push_back({Kind::kMissingScan, path + ": cannot be read"});
    return read;
  }
  if (bytes->empty()) {
    read.faults.push_back({Kind::kEmptyScan, path + ": no points"});
    return read;
  }
  if (bytes->size() % kPointBytes != 0) {
    read.faults.push_back({Kind::kTruncatedScan, path + ": " + std::to_string(bytes->size()) +
                                                     " bytes, not a multiple of 16: cut off"});
    return read;
  }
  LidarScan scan = Decode(*bytes);
  const size_t dropped = bytes->size() / kPointBytes - scan.size();
  if (dropped > 0) {
    read.faults.push_back({Kind::kInvalidPoints, path + ": " + std::to_string(dropped) +
                                                     " points are not finite and were dropped"});
  }
  if (scan.size() == 0) {
    read.faults.push_back({Kind::kEmptyScan, path + ": no valid point"});
    return read;
  }
  read.turns = CountAzimuthTurns(scan.points);
  const std::string truncation = Truncation(scan, read.turns, expected);
  if (!truncation.empty()) {
    read.faults.push_back({Kind::kTruncatedScan, path + ": " + truncation});
    return read;
  }
  read.scan = std::make_shared<const LidarScan>(std::move(scan));
  return read;
}

void WriteVelodyneBin(const std::string& path, const LidarScan& scan) {
  WriteAtomically(path, [&](std::ostream& out) {
    std::vector<float> row(4 * scan.size());
    for (size_t i = 0; i < scan.size(); ++i) {
      const Eigen::Vector3f& p = scan.points[i];
      const float intensity = scan.intensity.empty() ? 0.0F : scan.intensity[i];
      const std::array<float, 4> v = {p.x(), p.y(), p.z(), intensity};
      std::copy(v.begin(), v.end(), row.begin() + static_cast<std::ptrdiff_t>(4 * i));
    }
    out.write(reinterpret_cast<const char*>(row.data()),
              static_cast<std::streamsize>(row.size() * sizeof(float)));
  });
}

}  // namespace tvl
