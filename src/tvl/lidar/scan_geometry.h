// Azimuth and range of every point of a scan, computed once for the steps that follow.
#pragma once

#include <cmath>
#include <vector>

#include "tvl/sensor/lidar_scan.h"

namespace tvl {

// One entry a point, in the order of the scan.
struct ScanGeometry {
  std::vector<float> azimuth_rad;  // (-pi, pi], 0 forward, counter-clockwise seen from above
  std::vector<float> range_m;      // 0 for points with a coordinate that is not finite
};

// Azimuth is good to 2e-5 rad (a polynomial; a seventh of a column of 2048 would be 4e-4).
// `reuse` may hand in a result of an earlier call, whose memory is then used again.
ScanGeometry ComputeScanGeometry(const LidarScan& scan, ScanGeometry reuse = {});

// Arctangent of y / x in the right quadrant, in (-pi, pi], to 2e-5 rad; 0 for (0, 0).
inline float FastAtan2(float y, float x) {
  constexpr float kPiF = 3.14159265f;
  const float ax = std::abs(x), ay = std::abs(y);
  const float large = ax > ay ? ax : ay;
  const float small = ax > ay ? ay : ax;
  const float a = large > 0.0f ? small / large : 0.0f;
  // Arctangent on [0, 1]; Abramowitz & Stegun, Handbook of Mathematical Functions, 4.4.49.
  const float s = a * a;
  float angle =
      a * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
  angle = ay > ax ? 0.5f * kPiF - angle : angle;
  angle = x < 0.0f ? kPiF - angle : angle;
  return y < 0.0f ? -angle : angle;
}

}  // namespace tvl
