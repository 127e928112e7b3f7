// A smooth motion through space, known at every instant.
#pragma once

#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl::sim {

// Uniform cubic B-spline over rotations (cumulative form) and positions: twice continuously
// differentiable, so that velocities of a sweep are those of a vehicle. It smooths its control
// poses, it does not pass through them. Const and thread-safe.
class PoseSpline {
 public:
  // Control pose i belongs to start_s + i * interval_s. Needs at least 4.
  PoseSpline(std::vector<Rigid3d> control, double start_s, double interval_s);

  // The pose at time_s; before the second and after the last but one control pose the ends are
  // held.
  Rigid3d At(double time_s) const;

 private:
  std::vector<Rigid3d> control_;
  double start_s_, interval_s_;
};

// Averages each pose with its neighbours, Gaussian weights of the given width in poses.
std::vector<Rigid3d> SmoothPoses(const std::vector<Rigid3d>& poses, double sigma_poses);

// `count` poses more at each end, going on at the velocity there.
std::vector<Rigid3d> ExtendPoses(const std::vector<Rigid3d>& poses, int count);

}  // namespace tvl::sim
