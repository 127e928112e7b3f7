#include "tvl/lidar/scan_geometry.h"

#include <cmath>
#include <utility>

namespace tvl {
namespace {

// Arctangent on [0, 1]; Abramowitz & Stegun, Handbook of Mathematical Functions, 4.4.49.
inline float AtanUnit(float a) {
  const float s = a * a;
  return a *
         (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
}

inline float Atan2(float y, float x) {
  constexpr float kPiF = 3.14159265f;
  const float ax = std::abs(x), ay = std::abs(y);
  const float large = ax > ay ? ax : ay;
  const float small = ax > ay ? ay : ax;
  float angle = large > 0.0f ? AtanUnit(small / large) : 0.0f;
  angle = ay > ax ? 0.5f * kPiF - angle : angle;
  angle = x < 0.0f ? kPiF - angle : angle;
  return y < 0.0f ? -angle : angle;
}

}  // namespace

float FastAtan2(float y, float x) { return Atan2(y, x); }

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
    out.azimuth_rad[i] = finite ? Atan2(p.y(), p.x()) : 0.0f;
  }
  return out;
}

}  // namespace tvl
