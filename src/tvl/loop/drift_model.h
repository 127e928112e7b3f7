// How wrong the estimated relative position of two keyframes may be (paper 6.2: R1 and R2).
//
// Model: error grows with the path driven, and an accepted loop takes it away. What counts is the
// shortest way from one keyframe to the other in the graph whose odometry edges are as long as the
// path driven over them and whose accepted loops have no length. Without loops that is the path
// driven in between; after a loop, a street driven in parallel is no further than the detour over
// the loop.
#pragma once

#include <vector>

namespace tvl {

// Two keyframes joined by an accepted loop, in either order.
struct LoopLink {
  int from = 0, to = 0;
};

// By keyframe in [0, current]: length (m) of the shortest way from `current`. O((n + l) log n):
// 0.3 ms for 4,500 keyframes and 300 loops. Links to keyframes after `current` are not followed.
// Throws Error for a keyframe that does not exist.
std::vector<double> LinkedPath(const std::vector<double>& path_m,
                               const std::vector<LoopLink>& loops, int current);

// The radius within which two estimates may mean one place: the larger of a floor and a share of
// the linked path.
struct DriftRadius {
  double floor_m;
  double share;  // of the linked path
  double Of(double linked_path_m) const;
};

struct DriftOptions {
  // R1 of the paper, for visual proposals: whatever a bag of words finds farther away is a
  // lookalike. 1 % is about ten times the odometry's drift.
  double visual_floor_m = 20.0;
  double visual_share = 0.01;
  // R2 < R1, for proposals without any evidence but the distance.
  double vicinity_floor_m = 10.0;
  double vicinity_share = 0.005;
  // For lidar proposals. Wide: this is what finds the way back after a bad stretch of odometry.
  double lidar_floor_m = 40.0;
  double lidar_share = 0.03;

  DriftRadius visual() const { return {visual_floor_m, visual_share}; }
  DriftRadius vicinity() const { return {vicinity_floor_m, vicinity_share}; }
  DriftRadius lidar() const { return {lidar_floor_m, lidar_share}; }
  void Check() const;
};

}  // namespace tvl
