// Keyframe poses and what was measured between them (paper 6.3, Fig. 9). Data only.
#pragma once

#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// A measured relative pose: Z = T_from_to. Its error e = Log(Z^-1 T_world_from^-1 T_world_to) is
// [rotation (rad), translation (m)] in the frame of `to`.
struct PoseConstraint {
  int from = 0, to = 0;  // indices of poses
  Rigid3d T_from_to;
  Matrix6d information = Matrix6d::Identity();  // inverse covariance of e
};

struct PoseGraph {
  std::vector<Rigid3d> T_world;  // T_world_lidar of every keyframe
  std::vector<PoseConstraint> odometry, loops;
};

}  // namespace tvl
