// Absolute trajectory error: how far positions are off after putting one path on the other.
#pragma once

#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// T_truth_estimate that minimises the squared distances of the positions: Umeyama's solution with
// scale 1. Both paths must have the same length > 0 (Error). Where the positions leave a rotation
// open (a straight line), it is the smallest that SVD gives; the distances do not depend on it.
Rigid3d AlignPositions(const std::vector<Rigid3d>& truth, const std::vector<Rigid3d>& estimate);

// T_truth_estimate that puts the first poses on each other.
Rigid3d AlignFirstPose(const std::vector<Rigid3d>& truth, const std::vector<Rigid3d>& estimate);

// |truth_i - T_truth_estimate estimate_i| at each frame, m.
std::vector<double> PositionErrors_m(const std::vector<Rigid3d>& truth,
                                     const std::vector<Rigid3d>& estimate,
                                     const Rigid3d& T_truth_estimate);

struct AbsoluteError {
  double rmse_m = 0.0, mean_m = 0.0, median_m = 0.0, max_m = 0.0;
};

// Of PositionErrors_m; throws Error if it is empty.
AbsoluteError SummariseErrors(std::vector<double> errors_m);

}  // namespace tvl
