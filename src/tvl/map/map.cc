#include "tvl/map/map.h"

#include "tvl/base/check.h"
#include "tvl/geometry/voxel_hash.h"

namespace tvl {
namespace {

// How far `pose` is from its anchor to the next keyframe, 0..1.
double ShareOfTheWay(const Rigid3d& T_anchor_pose, const Rigid3d& T_anchor_next) {
  const double to_pose_m = T_anchor_pose.t().norm();
  const double rest_m = (T_anchor_next.t() - T_anchor_pose.t()).norm();
  return to_pose_m + rest_m > 0.0 ? to_pose_m / (to_pose_m + rest_m) : 0.0;
}

Rigid3d BetweenKeyframes(const Keyframe& anchor, const Keyframe& next, const Rigid3d& T_odom) {
  const Rigid3d T_anchor_pose = anchor.T_odom_lidar.Inverse() * T_odom;
  const Rigid3d T_anchor_next = anchor.T_odom_lidar.Inverse() * next.T_odom_lidar;
  const Rigid3d T_anchor_next_world = anchor.T_world_lidar.Inverse() * next.T_world_lidar;
  const Rigid3d correction = T_anchor_next.Inverse() * T_anchor_next_world;
  const double share = ShareOfTheWay(T_anchor_pose, T_anchor_next);
  return anchor.T_world_lidar * T_anchor_pose * Scale(share, correction);
}

}  // namespace

Rigid3d ToWorld(const Keyframe& anchor, const Rigid3d& T_odom_lidar) {
  return anchor.T_world_lidar * (anchor.T_odom_lidar.Inverse() * T_odom_lidar);
}

Trajectory WorldTrajectory(const OdometryPath& path, const std::vector<Keyframe>& keyframes) {
  Trajectory trajectory;
  trajectory.reserve(path.size());
  for (const OdometryPose& pose : path) {
    Rigid3d T_world_lidar = pose.T_odom_lidar;
    if (pose.anchor >= 0) {
      const auto anchor = static_cast<size_t>(pose.anchor);
      T_world_lidar =
          anchor + 1 < keyframes.size()
              ? BetweenKeyframes(keyframes[anchor], keyframes[anchor + 1], pose.T_odom_lidar)
              : ToWorld(keyframes[anchor], pose.T_odom_lidar);
    }
    trajectory.push_back({pose.frame, pose.stamp, T_world_lidar});
  }
  return trajectory;
}

std::vector<Keyframe> WithoutLoops(std::vector<Keyframe> keyframes) {
  for (size_t i = 1; i < keyframes.size(); ++i) {
    keyframes[i].T_world_lidar = keyframes[i - 1].T_world_lidar * keyframes[i].T_prev_cur;
  }
  return keyframes;
}

MapCloud BuildMapCloud(const Map& map, double voxel_m) {
  TVL_CHECK_INPUT(voxel_m > 0.0) << "map voxel: must be positive, is " << voxel_m;
  VoxelHash<char> seen;
  MapCloud cloud;
  for (const Keyframe& keyframe : map.keyframes) {
    const auto points = map.store->Cloud(keyframe.id.index);
    for (const FeatureCloud* part : {&points->planes, &points->edges}) {
      for (size_t i = 0; i < part->points.size(); ++i) {
        const Eigen::Vector3d p = keyframe.T_world_lidar * part->points[i].cast<double>();
        char& taken = seen[VoxelKey::Of(p, voxel_m)];
        if (taken != 0) continue;
        taken = 1;
        cloud.points.push_back(p.cast<float>());
        cloud.intensity.push_back(part->intensity[i]);
      }
    }
  }
  return cloud;
}

}  // namespace tvl
