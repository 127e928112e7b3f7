// A point cloud in the world frame: what is exported.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tvl {

struct MapCloud {
  std::vector<Eigen::Vector3f> points;  // p_world, m
  std::vector<float> intensity;         // 0..1; as long as points
};

}  // namespace tvl
