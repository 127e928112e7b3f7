// What goes into loop closing and what comes out.
#pragma once

#include <memory>
#include <vector>

#include "tvl/map/keyframe.h"
#include "tvl/map/loop.h"

namespace tvl {

// A new keyframe as loop closing sees it.
struct LoopJob {
  Keyframe keyframe;  // its T_world_lidar is not read
  // T_prev_cur of the odometry since the previous keyframe, and its covariance (right
  // perturbation).
  Rigid3d T_prev_cur;
  Matrix6d covariance = Matrix6d::Zero();
};

// What loop closing makes of the keyframes 0..last.
struct LoopUpdate {
  int last = -1;
  std::vector<Rigid3d> T_world_lidar;  // of keyframes 0..last; empty: only the last is new
  Rigid3d T_world_last;                // of keyframe `last`
  // Keyframes that accepted loops make neighbours of `last`, best first.
  std::vector<int> connected;
};

}  // namespace tvl
