// How far apart two keyframes of a drive are, as loop detection counts it (paper 6.2).
#pragma once

#include <vector>

#include "tvl/base/time.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// The keyframes as the proposers see them, one entry each, in the order they were made. Stamps and
// driven lengths never decrease; the poses are the present estimate and may change any time.
struct KeyframeTrack {
  std::vector<Timestamp> stamp;
  std::vector<double> path_m;  // length driven up to here
  std::vector<Rigid3d> T_world_lidar;

  int size() const { return static_cast<int>(stamp.size()); }
  // Throws Error unless the three are of one length.
  void Check() const;
};

struct LoopSeparationOptions {
  // The paper's t_th. Time alone is not enough: at a red light it passes without a metre driven.
  double min_time_s = 30.0;
  // Nor is length: a tight turn at a junction is no revisit.
  double min_path_m = 50.0;
  // Two drives past one place are separate passes if the keyframes near it leave out this much of
  // the path in between.
  double pass_gap_m = 20.0;
  void Check() const;
};

// The number n of keyframes old enough to close a loop with `current`: those in [0, n) are more
// than min_time_s and more than min_path_m back. Throws Error if `current` is not in the track.
int EligibleHistory(const KeyframeTrack& track, int current, const LoopSeparationOptions& options);

// Cuts keyframe indices (ascending) where more than pass_gap_m of path lies between neighbours.
std::vector<std::vector<int>> SeparatePasses(const std::vector<int>& keyframes,
                                             const std::vector<double>& path_m,
                                             const LoopSeparationOptions& options);

}  // namespace tvl
