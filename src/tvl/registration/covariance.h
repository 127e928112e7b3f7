// From the curvature of a cost to an honest covariance.
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

struct CovarianceOptions {
  // Residuals of one scan share their errors (beams, normals, time): the raw inverse Hessian is too
  // confident by about this factor in variance.
  double inflation = 30.0;
  // Floors of one step, as shares of its length: real odometry drifts by no less (design 4.5).
  double floor_translation = 0.003;          // m / m
  double floor_rotation_rad_per_m = 5.2e-5;  // 0.003 deg / m
  // What remains of a step of zero length.
  double floor_translation_m = 5e-4, floor_rotation_rad = 2e-5;
  void Check() const;
};

// (H / inflation + prior)^-1 plus the floors for a step of `length_m`. `H` is what the residuals
// say; `prior` is information that is honest already. Directions that neither holds get a standard
// deviation of 10 (rad, m).
Matrix6d HonestCovariance(const Matrix6d& H, double length_m, const CovarianceOptions& options,
                          const Matrix6d& prior = Matrix6d::Zero());

}  // namespace tvl
