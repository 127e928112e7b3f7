// Registration of a source against a submap, coarse to fine (paper 6.3).
#pragma once

#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/loop/loop_source.h"
#include "tvl/loop/loop_submap.h"
#include "tvl/registration/covariance.h"
#include "tvl/registration/surfel_matcher.h"
#include "tvl/registration/weakness.h"

namespace tvl {

// Measured on true loops of simulated drives (NEES 0.3 to 1.1): most errors shared by residuals
// average out over many scans. The floors stand for what bends within a submap: on a real street,
// passes with an odometry each and seen from some metres apart, NEES is 1.5 to 2.3 with floors of
// 2e-4 rad and 4 mm.
inline CovarianceOptions ForLoops() {
  CovarianceOptions options;
  options.inflation = 4.0;
  options.floor_rotation_rad = 5e-4;
  options.floor_translation_m = 0.01;
  return options;
}

struct LoopRegistrationOptions {
  // Matches further off than the gate are dropped, one round each; the noise assumed of a point is
  // gate_share of the gate, so that early rounds do not mistake an offset for outliers.
  std::vector<double> coarse_gates_m = {2.0, 1.5, 1.0};  // from a grid cell off to a decimetre
  std::vector<double> fine_gates_m = {0.5, 0.4, 0.3, 0.3, 0.3};
  double gate_share = 0.25;
  int coarse_every_point = 3;  // starts are many, and need no precision
  double kernel_sigmas = 2.0;  // Cauchy
  MatchNoise noise;
  WeaknessOptions weakness;
  CovarianceOptions covariance = ForLoops();
  void Check() const;
};

struct LoopRegistration {
  Rigid3d T_odom_current;
  Matrix6d covariance = Matrix6d::Identity();  // right perturbation, current frame
  double translation_ratio = 0.0, rotation_ratio = 0.0;
  int matches = 0;
};

// From a start within about a metre and 3 degrees to a few decimetres.
Rigid3d RegisterCoarsely(const LoopSource& source, const LoopSubmap& submap,
                         const Rigid3d& T_odom_current, const LoopRegistrationOptions& options,
                         const Executor& executor);

// From there to centimetres.
LoopRegistration RegisterFinely(const LoopSource& source, const LoopSubmap& submap,
                                const Rigid3d& T_odom_current,
                                const LoopRegistrationOptions& options, const Executor& executor);

}  // namespace tvl
