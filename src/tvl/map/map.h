// Keyframes with their poses and payloads: all there is to know of the world.
#pragma once

#include <memory>
#include <vector>

#include "tvl/map/keyframe.h"
#include "tvl/map/keyframe_store.h"
#include "tvl/map/map_cloud.h"
#include "tvl/map/trajectory.h"

namespace tvl {

// Keyframes in the order they were made, keyframes[i].id.index == i. No rule ties the world's
// origin to the first of them.
struct Map {
  std::vector<Keyframe> keyframes;
  std::shared_ptr<KeyframeStore> store;  // payloads are shared with the loop thread
};

// A frame of the odometry and the keyframe it hangs on.
struct OdometryPose {
  FrameId frame = 0;
  Timestamp stamp;
  int anchor = -1;  // index of the last keyframe made up to here; -1: none yet
  Rigid3d T_odom_lidar;
};
using OdometryPath = std::vector<OdometryPose>;

// T_world_lidar of a pose of the odometry that hangs on `anchor`.
Rigid3d ToWorld(const Keyframe& anchor, const Rigid3d& T_odom_lidar);

// Poses of all frames in the world: each follows its keyframe, and what the next keyframe was moved
// by beyond that is spread over the frames between the two. Poses without anchor stay.
Trajectory WorldTrajectory(const OdometryPath& path, const std::vector<Keyframe>& keyframes);

// The keyframes where the odometry has them, before loops correct it: the first stays.
std::vector<Keyframe> WithoutLoops(std::vector<Keyframe> keyframes);

// The map in the world frame: all keyframe clouds at their poses, one point a voxel.
MapCloud BuildMapCloud(const Map& map, double voxel_m);

}  // namespace tvl
