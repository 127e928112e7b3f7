// Relative pose error: how far motions over a fixed stretch are off.
#pragma once

#include <cstddef>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// The error of the motion a -> b, (G_a^-1 G_b)^-1 (E_a^-1 E_b). Over the whole drive this is D of
// the paper's Table 1.
struct MotionError {
  double translation_m = 0.0;
  double rotation_deg = 0.0;
};
MotionError ErrorOfMotion(const Rigid3d& truth_a, const Rigid3d& truth_b, const Rigid3d& estimate_a,
                          const Rigid3d& estimate_b);

// Root mean square over all stretches of a drive.
struct RelativeError {
  size_t count = 0;  // stretches; 0: the drive is too short, the rest is 0
  double translation_rmse_m = 0.0;
  double rotation_rmse_deg = 0.0;
};

// Over stretches of one frame. Throws Error if the lengths differ.
RelativeError RelativeErrorPerFrame(const std::vector<Rigid3d>& truth,
                                    const std::vector<Rigid3d>& estimate);

// Over stretches that begin at every frame and end with the first one more than `distance_m` of
// true path later. Throws Error if the lengths differ.
RelativeError RelativeErrorPerDistance(const std::vector<Rigid3d>& truth,
                                       const std::vector<Rigid3d>& estimate, double distance_m);

}  // namespace tvl
