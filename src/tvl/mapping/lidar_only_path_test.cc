#include "tvl/mapping/lidar_only_path.h"

#include <gtest/gtest.h>

#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::Twist;

std::shared_ptr<const KeyframeCloud> CloudAt(const synthetic::World& world, const Rigid3d& T,
                                             uint64_t seed) {
  const LaserFeatures features =
      synthetic::SampleFeatures(world, synthetic::Standing(T), Deskew::kNone, {0.02, seed});
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = synthetic::PointsOf(features.less_flat);
  cloud->edges.points = synthetic::PointsOf(features.less_sharp);
  return cloud;
}

LidarOnlyPath MakePath() {
  return {synthetic::CameraAndLidar(), ScanToMapOptions(), LocalMapOptions(), KeyframeOptions()};
}

std::optional<LidarPose> Add(const std::shared_ptr<const KeyframeCloud>& cloud,
                             const Rigid3d& T_odom_lidar, LidarOnlyPath* path) {
  const MapStepPoints points =
      ThinForMapStep(cloud->planes.points, cloud->edges.points, ScanToMapOptions().source_voxel_m);
  return path->Add(points, cloud, T_odom_lidar, Executor(1));
}

// Straight on, a metre a scan.
Rigid3d At(int scan) { return Rigid3d::Translation(scan, 0.0, 0.0); }

// The poses that are believed leave the way by 1.1 deg, as a camera that points aside draws them.
TEST(LidarOnlyPath, DoesNotFollowPosesThatLeaveTheWay) {
  const synthetic::World street = synthetic::Street();
  for (const double side : {1.0, -1.0}) {
    LidarOnlyPath path = MakePath();
    std::optional<LidarPose> pose;
    for (int scan = 0; scan <= 10; ++scan) {
      const Rigid3d T_believed = Rigid3d::Translation(scan, side * 0.02 * scan, 0.0);
      pose = Add(CloudAt(street, At(scan), 40 + static_cast<uint64_t>(scan)), T_believed, &path);
      EXPECT_EQ(pose.has_value(), scan > 0) << scan;
    }
    ASSERT_TRUE(pose.has_value());
    const double across_m = pose->T_odom_lidar.t().y();
    EXPECT_NEAR(across_m, 0.0, 0.03) << "believed: " << 0.2 * side;
    EXPECT_NEAR(pose->T_odom_lidar.t().x(), 10.0, 0.05);
    const double sigma_m = std::sqrt(pose->covariance(4, 4));
    EXPECT_GT(sigma_m, 0.0005);
    EXPECT_LT(sigma_m, 0.02);
  }
}

TEST(LidarOnlyPath, BeginsAnewOnceItHasForgotten) {
  const synthetic::World street = synthetic::Street();
  LidarOnlyPath path = MakePath();
  Add(CloudAt(street, At(0), 1), At(0), &path);
  EXPECT_TRUE(Add(CloudAt(street, At(1), 2), At(1), &path).has_value());
  path.Forget();
  EXPECT_FALSE(Add(CloudAt(street, At(5), 3), At(5), &path).has_value());
  const std::optional<LidarPose> pose = Add(CloudAt(street, At(6), 4), At(6), &path);
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->T_odom_lidar.t().x(), 1.0, 0.05) << "since it began";
}

TEST(LidarOnlyPath, FindsNoPoseWithoutAScan) {
  LidarOnlyPath path = MakePath();
  Add(CloudAt(synthetic::Street(), At(0), 1), At(0), &path);
  EXPECT_FALSE(Add(std::make_shared<const KeyframeCloud>(), At(1), &path).has_value());
}

}  // namespace
}  // namespace tvl
