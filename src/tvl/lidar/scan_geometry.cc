#include "tvl/lidar/scan_geometry.h"

#include <cmath>
#include <utility>

namespace tvl {

ScanGeometry ComputeScanGeometry(const LidarScan& scan, ScanGeometry reuse) {
  ScanGeometry out = std::move(reuse);
  const size_t n = scan.size();
  out.azimuth_rad.resize(n);
  out.range_m.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f& p = scan.points[i];
    const float range_sq = p.x() * p.x() + p.y() * p.y() + p.z() * p.z();
    const bool finite = range_sq < 1e30f;  // false for NaN and infinity
    out.range_m[i] = finite ? std::sqrt(range_sq) : 0.0f;
    out.azimuth_rad[i] = finite ? FastAtan2(p.y(), p.x()) : 0.0f;
  }
  return out;
}

}  // namespace tvl
