// Do loops agree with each other? Two loops and the odometry between their ends make a cycle, which
// must close within its uncertainty (pairwise consistency, Mangelson et al. 2018).
#pragma once

#include <vector>

#include "tvl/base/index.h"
#include "tvl/map/pose_graph.h"

namespace tvl {

// Relative poses by odometry alone, with their covariances, between any two poses in constant time.
// A few 0.01 m^2 are lost to rounding beyond 100 km from the first pose.
class OdometryChain {
 public:
  OdometryChain();
  // From the last pose to the next one. Throws Error if it links any others.
  void Add(const PoseConstraint& odometry);
  int size() const { return static_cast<int>(T_first_.size()); }

  struct Relative {
    Rigid3d T_i_j;
    Matrix6d covariance;  // of T_i_j by a right perturbation, in the frame of j
  };
  // In either direction.
  Relative Between(int i, int j) const;
  const Rigid3d& T_first(int i) const { return T_first_[Index(i)]; }
  // Covariance of what the odometry drifts from i to j or back, as a left perturbation in the frame
  // of the first pose.
  Matrix6d Drift(int i, int j) const;

 private:
  std::vector<Rigid3d> T_first_;      // of every pose
  std::vector<Matrix6d> covariance_;  // of T_first_ by a left perturbation: sums along the way
};

// Squared error of the cycle of two loops, whitened by the covariances of both loops and of the
// odometry between their ends; chi-square of 6 if both are true.
double CycleErrorSq(const OdometryChain& odometry, const PoseConstraint& a,
                    const PoseConstraint& b);

// The largest set of loops found that all agree pairwise, ascending indices: greedy growth from
// each loop, the best connected first. Cycles of two agree up to `max_error_sq`.
std::vector<int> ConsistentSet(const OdometryChain& odometry,
                               const std::vector<PoseConstraint>& loops, double max_error_sq);

}  // namespace tvl
