#include "tvl/map/map.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

Rigid3d Pose(double yaw_rad, double x, double y) {
  Vector6d w = Vector6d::Zero();
  w[2] = yaw_rad;
  return Rigid3d::Translation(x, y, 0.0) * Rigid3d::Exp(w);
}

Keyframe MakeKeyframe(const Rigid3d& T_odom, const Rigid3d& T_world) {
  Keyframe keyframe;
  keyframe.T_odom_lidar = T_odom;
  keyframe.T_world_lidar = T_world;
  return keyframe;
}

TEST(WorldTrajectory, FollowsTheKeyframesAndSpreadsWhatIsBetween) {
  const std::vector<Keyframe> keyframes = {
      MakeKeyframe(Pose(0.0, 0, 0), Pose(0.5, 10, 0)),
      MakeKeyframe(Pose(0.0, 1, 0), Pose(0.5, 10, 0) * Pose(0.02, 1.1, 0))};
  const OdometryPath path = {{0, {}, -1, Pose(0, -3, 0)}, {1, {}, 0, Pose(0, 0, 0)},
                             {2, {}, 0, Pose(0, 0.5, 0)}, {3, {}, 0, Pose(0, 0.999999, 0)},
                             {4, {}, 1, Pose(0, 1, 0)},   {5, {}, 1, Pose(0, 2, 0)}};
  const Trajectory world = WorldTrajectory(path, keyframes);
  ASSERT_EQ(world.size(), path.size());
  EXPECT_THAT(world[0].T_world_lidar, Rigid3dNear(Pose(0, -3, 0), 1e-12, 1e-12));
  EXPECT_THAT(world[1].T_world_lidar, Rigid3dNear(keyframes[0].T_world_lidar, 1e-12, 1e-12));
  EXPECT_THAT(world[3].T_world_lidar, Rigid3dNear(keyframes[1].T_world_lidar, 1e-6, 1e-5));
  EXPECT_THAT(world[4].T_world_lidar, Rigid3dNear(keyframes[1].T_world_lidar, 1e-12, 1e-12));
  EXPECT_THAT(world[5].T_world_lidar,
              Rigid3dNear(keyframes[1].T_world_lidar * Pose(0, 1, 0), 1e-12, 1e-12));
  EXPECT_THAT(world[2].T_world_lidar,
              Rigid3dNear(keyframes[0].T_world_lidar * Pose(0.01, 0.55, 0), 1e-3, 1e-3));
}

TEST(MapCloud, PlacesKeyframesAndThins) {
  Map map;
  map.store = std::make_shared<KeyframeStore>(KeyframeStoreOptions());
  map.keyframes = {MakeKeyframe(Rigid3d(), Rigid3d()),
                   MakeKeyframe(Rigid3d(), Rigid3d::Translation(0, 10, 0))};
  for (int i = 0; i < 2; ++i) {
    auto payload = std::make_shared<KeyframePayload>();
    payload->cloud.planes = {{{1.01F, 2.01F, 0.01F}, {1.02F, 2.02F, 0.02F}}, {0.25F, 0.5F}};
    payload->cloud.edges = {{{5.01F, 0.01F, 0.01F}}, {0.75F}};
    map.keyframes[static_cast<size_t>(i)].id.index = i;
    map.store->Put(i, payload);
  }
  const MapCloud cloud = BuildMapCloud(map, 0.1);
  ASSERT_EQ(cloud.points.size(), 4U);
  EXPECT_EQ(cloud.points[2], Eigen::Vector3f(1.01F, 12.01F, 0.01F));
  EXPECT_EQ(cloud.intensity, (std::vector<float>{0.25F, 0.75F, 0.25F, 0.75F}));
  EXPECT_THROW(BuildMapCloud(map, 0.0), InputError);
}

}  // namespace
}  // namespace tvl
