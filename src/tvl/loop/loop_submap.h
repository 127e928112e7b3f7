// The surroundings of a history keyframe, for verification (paper 6.3: +-25 keyframes).
//
// Assembled in the odometry frame, whose poses never change: neighbouring candidates share most of
// a submap, which slides along instead of being rebuilt. Sliding leaves no trace: integer moments
// and counts are taken away exactly.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/loop/seen_ranges.h"
#include "tvl/map/keyframe.h"
#include "tvl/registration/surfel_map.h"

namespace tvl {

// Clouds may be paged to disk: fetched when needed, not kept. The same keyframe must give the same
// points every time.
using KeyframeCloudSource = std::function<std::shared_ptr<const KeyframeCloud>(int keyframe)>;

struct LoopSubmapOptions {
  int keyframes_each_way = 25;  // paper 6.3; about 25 m
  int every_keyframe = 2;       // 2 m apart suffice: each sees 50 m
  int every_point = 3;          // of F_lf: 5,000 of 15,000 a keyframe; surfels want 8 in a voxel
  double voxel_m = 0.5;         // of the occupancy (design 4.7)
  int every_view = 2;           // of these: their view tells what the submap could see
  // Beyond, a keyframe sees the ground in arcs metres apart, no surfaces: what it saw there says
  // little of what must be there.
  double view_range_m = 25.0;
  double view_margin_m = 0.5;  // seen that much less far: still at the point
  SurfelMapOptions planes{SurfelKind::kPlane, {0.5, 1.0, 2.0}, {}};
  SurfelMapOptions lines{SurfelKind::kLine, {1.0}, {5, 0.12, 3.0, 0.12}};
  void Check() const;
};

// Not thread-safe while it moves.
class LoopSubmap {
 public:
  explicit LoopSubmap(const LoopSubmapOptions& options);

  // Moves to keyframe `centre` of `T_odom_lidar`: everything within keyframes_each_way of it.
  // `end` is the first keyframe that must not be in it (the current one's stretch).
  void MoveTo(int centre, int end, const std::vector<Rigid3d>& T_odom_lidar,
              const KeyframeCloudSource& cloud, const Executor& executor);

  const SurfelMap& planes() const { return *planes_; }
  const SurfelMap& lines() const { return *lines_; }
  bool IsOccupied(const Eigen::Vector3d& p_odom) const;
  // Whether one of its keyframes saw as far as there, so that something there would be known.
  bool CouldSee(const Eigen::Vector3d& p_odom) const;
  // Whether one of them saw at least view_margin_m past it: it was not there, or is thin.
  bool SawThrough(const Eigen::Vector3d& p_odom) const;
  // Centres of occupied voxels.
  std::vector<Eigen::Vector3d> OccupiedCentres() const;
  // Poses T_odom_lidar of the keyframes in it, by index.
  const std::map<int, Rigid3d>& members() const { return members_; }

 private:
  void Change(const KeyframeCloud& cloud, const Rigid3d& T_odom_lidar, int sign,
              const Executor& executor);
  void Count(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_odom_lidar, int sign);
  void Clear();
  bool SawAtLeast(const Eigen::Vector3d& p_odom, double further_m) const;
  void DropEmpty();

  LoopSubmapOptions options_;
  std::map<int, Rigid3d> members_;
  std::unique_ptr<SurfelMap> planes_, lines_;
  struct View {
    Eigen::Vector3d place_odom;
    Rigid3d T_lidar_odom;
    SeenRanges seen;
  };
  std::map<int, View> views_;     // by keyframe
  VoxelHash<int32_t> occupancy_;  // points in each voxel
};

}  // namespace tvl
