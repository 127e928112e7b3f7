// The pose between two images from matched features, some with depth: PnP with RANSAC, refined
// (paper 6.2).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

struct PnpOptions {
  // Angle between where a point is seen and where it should be: 3.6 px of KITTI's camera. Corners
  // are whole pixels in both images, and depths are those of small planes.
  double max_error_rad = 0.005;
  // Fewer agree by chance, or hang on one car. (Brief 4.7.)
  int min_inliers = 25;
  // Of the matches with depth: a wrong pose gathers a crowd where matches are many and wrong.
  double min_inlier_share = 0.3;
  double confidence = 0.999;  // of having drawn one sample free of outliers
  int max_iterations = 400;   // enough for one inlier in four at that confidence
  int seed = 1;               // the same samples for the same matches

  void Check() const;  // throws InputError naming the field
};

// A feature seen in both images. A depth of 0 is not known.
struct PnpMatch {
  Eigen::Vector2d ray_history, ray_current;  // normalised, undistorted (z = 1)
  double depth_history_m = 0.0, depth_current_m = 0.0;
};

enum class PnpStatus {
  kFound,
  kFewPoints,   // too few matches have a depth
  kFewInliers,  // no pose gathers enough of them
};

struct PnpResult {
  PnpStatus status = PnpStatus::kFewPoints;
  Rigid3d T_history_current;  // camera frames; valid for kFound
  int points = 0;             // matches with a depth on either side
  int inliers = 0;            // of them
};

// Points of either image with depth are held against their rays in the other: the history's depths
// as the paper does, the current ones too, as there are always too few. Deterministic.
PnpResult SolvePnp(const std::vector<PnpMatch>& matches, const PnpOptions& options);

}  // namespace tvl
