// What is laid over a history submap: the current keyframe and a stretch before it (paper 6.3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/loop/loop_submap.h"

namespace tvl {

struct LoopSourceOptions {
  // Only keyframes of the past exist when a loop is suspected, and at the end of the data.
  int keyframes_back = 10;
  int every_keyframe = 2;
  double range_m = 40.0;        // of points from their own keyframe: beyond, rings lie metres apart
  double plane_voxel_m = 1.0;   // thinning of F_lf for registration; even coverage, as in mapping
  double edge_voxel_m = 0.5;    // of F_ls
  double raised_voxel_m = 0.5;  // of what stands above the ground: overlap counts these
  double raised_m = 0.75;       // above the lowest point nearby: kerbs are ground, hedges are not
  void Check() const;
};

// All in the lidar frame of the current keyframe, m.
struct LoopSource {
  std::vector<Eigen::Vector3f> planes, edges;  // for registration
  std::vector<char> plane_is_raised;           // of each of `planes`: stands above the ground
  std::vector<Eigen::Vector3f> raised;         // one point a voxel, planes and edges
};

LoopSource AssembleSource(int current, const std::vector<Rigid3d>& T_odom_lidar,
                          const KeyframeCloudSource& cloud, const LoopSourceOptions& options);

}  // namespace tvl
