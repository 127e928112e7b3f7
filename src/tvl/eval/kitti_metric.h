// The odometry metric of the KITTI benchmark: errors of motions over 100, 200, ..., 800 m, begun at
// every tenth frame, as a share of the length. Written from its published definition; the same
// choice of frames as its development kit, so that figures compare.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

inline constexpr std::array<double, 8> kKittiLengths_m = {100, 200, 300, 400, 500, 600, 700, 800};
inline constexpr size_t kKittiStep_frames = 10;

// One stretch of a drive.
struct SegmentError {
  size_t first = 0, last = 0;  // frames
  double length_m = 0.0;       // one of kKittiLengths_m
  double t_err_m_per_m = 0.0;
  double r_err_deg_per_m = 0.0;
};

// All stretches that fit; empty for drives under 100 m. Throws Error if the lengths differ.
std::vector<SegmentError> KittiSegmentErrors(const std::vector<Rigid3d>& truth,
                                             const std::vector<Rigid3d>& estimate);

// Mean over stretches. The benchmark weighs every stretch of all drives alike: join their segments
// before. The mean over drives differs (design: 0.551 / 0.520 % for the same trajectories).
struct KittiError {
  size_t segments = 0;  // 0: nothing long enough, the rest is 0
  double t_err_percent = 0.0;
  double r_err_deg_per_m = 0.0;
  double r_err_deg_per_100m() const { return 100.0 * r_err_deg_per_m; }
};
KittiError MeanError(const std::vector<SegmentError>& segments);

// The same by length, in the order of kKittiLengths_m.
std::array<KittiError, kKittiLengths_m.size()> MeanErrorByLength(
    const std::vector<SegmentError>& segments);

}  // namespace tvl
