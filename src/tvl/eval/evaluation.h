// Everything `tvl evaluate` says about trajectories with known truth.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tvl/eval/absolute_error.h"
#include "tvl/eval/kitti_metric.h"
#include "tvl/eval/relative_error.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct DriveEvaluation {
  std::string name;
  size_t frames = 0;
  double truth_length_m = 0.0, estimate_length_m = 0.0;
  KittiError kitti;
  std::array<KittiError, kKittiLengths_m.size()> kitti_by_length;
  std::vector<SegmentError> segments;
  AbsoluteError ate;             // positions aligned by SE(3), no scale
  AbsoluteError ate_first_pose;  // first poses on each other
  RelativeError rpe_frame, rpe_10m, rpe_100m;
  MotionError total;  // paper Table 1: D = (G_0^-1 G_N)^-1 (E_0^-1 E_N)
};

// `truth` and `estimate` are poses of the same frames in the same sensor frame (camera 0), each in
// a world of its own. Throws InputError naming `name` if the lengths differ or are under 2.
DriveEvaluation EvaluateDrive(const std::string& name, const std::vector<Rigid3d>& truth,
                              const std::vector<Rigid3d>& estimate);

// Several drives together.
struct Evaluation {
  std::vector<DriveEvaluation> drives;
  KittiError segment_mean;  // every stretch of all drives alike: the benchmark's figure
  KittiError drive_mean;    // every drive alike, those without a stretch left out
};
Evaluation Combine(std::vector<DriveEvaluation> drives);

}  // namespace tvl
