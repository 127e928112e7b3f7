// One revolution of a spinning lidar.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tvl {

// Structure of arrays, one entry a point, in the order the sensor's file has them.
// `intensity`, `ring` and `time_offset_s` are either empty or as long as `points`.
struct LidarScan {
  std::vector<Eigen::Vector3f> points;  // p_lidar (x forward, y left, z up), m
  std::vector<float> intensity;         // 0..1
  std::vector<uint16_t> ring;           // row of the LidarModel, 0 = topmost
  // Seconds from the frame's stamp to the instant the point was measured (negative before).
  // Empty where the sensor gives none: it is then derived from azimuth and spin direction.
  std::vector<float> time_offset_s;

  size_t size() const { return points.size(); }
};

}  // namespace tvl
