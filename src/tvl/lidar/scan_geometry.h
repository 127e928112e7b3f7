// Azimuth and range of every point of a scan, computed once for the steps that follow.
#pragma once

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
float FastAtan2(float y, float x);

}  // namespace tvl
