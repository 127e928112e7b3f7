// For tests: paths whose errors can be worked out by hand.
#pragma once

#include <cmath>
#include <vector>

#include "tvl/base/units.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// `frames` poses of camera 0 (z forward), `step_m` apart, turning about the vertical (y) by
// `turn_rad` after each step. Constant motion: every stretch of n frames is the same.
inline std::vector<Rigid3d> ConstantMotion(size_t frames, double step_m, double turn_rad) {
  const Rigid3d step(ExpSo3(Eigen::Vector3d(0.0, turn_rad, 0.0)), Eigen::Vector3d(0, 0, step_m));
  std::vector<Rigid3d> poses(1);
  while (poses.size() < frames) poses.push_back(poses.back() * step);
  return poses;
}

// The poses with their positions multiplied.
inline std::vector<Rigid3d> Scaled(std::vector<Rigid3d> poses, double scale) {
  for (Rigid3d& pose : poses) pose = Rigid3d(pose.q(), scale * pose.t());
  return poses;
}

// The same path in another world.
inline std::vector<Rigid3d> Moved(std::vector<Rigid3d> poses, const Rigid3d& T_new_old) {
  for (Rigid3d& pose : poses) pose = T_new_old * pose;
  return poses;
}

}  // namespace tvl
