// How far a frame is searched for, see pose_search.h.
#pragma once

#include "tvl/loop/bev_alignment.h"

namespace tvl {

// More peaks than loops want: the map decides among them.
inline BevAlignmentOptions ForPoseSearch() {
  BevAlignmentOptions options;
  options.peaks = 24;
  return options;
}

struct PoseSearchOptions {
  // How far from the last known pose an alignment is searched, m: what a car at 36 m/s moves in a
  // second, and as far as two scans of a street share what stands there.
  double radius_m = 36.0;
  // Before any velocity is known, from one frame to the next: 45 m/s at 10 Hz.
  double start_radius_m = 4.5;
  double yaw_window_rad = 0.35;  // half: a car turns by no more in a second at speed
  // While lost it grows with time, as a car turns at a crossing, up to a right angle.
  double lost_yaw_rate_rad_per_s = 0.7;
  double max_yaw_window_rad = 1.6;
  double min_height_m = 0.7;  // above the ground: what stands, and no kerb or slope
  int max_followed = 6;       // of the alignments, those that lie best on the map as they are
  BevAlignmentOptions bev = ForPoseSearch();
  void Check() const;
};

}  // namespace tvl
