// How a measured point moves with the errors of its beam.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace tvl {

// Derivatives of a point (lidar frame) with its beam's elevation (m / rad) and range (m / m).
struct BeamDirections {
  Eigen::Vector3d elevation, range;
};

inline BeamDirections DirectionsAt(const Eigen::Vector3d& p_lidar) {
  const double horizontal_m = std::max(1e-6, p_lidar.head<2>().norm());
  const double lift = -p_lidar.z() / horizontal_m;
  return {{lift * p_lidar.x(), lift * p_lidar.y(), horizontal_m}, p_lidar.normalized()};
}

}  // namespace tvl
