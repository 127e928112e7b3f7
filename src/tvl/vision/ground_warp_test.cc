#include "tvl/vision/ground_warp.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tvl/base/rng.h"
#include "tvl/vision/feature_tracker.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

Camera TestCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 720.0;
  camera.cx_px = 620.0;
  camera.cy_px = 187.0;
  camera.width_px = 1242;
  camera.height_px = 375;
  return camera;
}

// The road 1.65 m below the camera, seen through `count` tracks with depth.
struct Road {
  explicit Road(int count, double noise_m = 0.02, uint64_t seed = 1) {
    const Camera camera = TestCamera();
    Rng rng(seed);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d p(rng.Uniform(-6, 6), 1.65 + noise_m * rng.Normal(),
                              rng.Uniform(6.0, 40.0));
      FeatureTrack track;
      track.id = i;
      track.ray_cam = p.hnormalized();
      track.px_cam = track.px_cam_prev = camera.Project(track.ray_cam);
      tracks.tracks.push_back(track);
      depths.push_back({DepthStatus::kOk, p.z(), 0.05, kLabelGround});
    }
  }
  FeatureTracks tracks;
  VisualDepths depths;
};

TEST(FitGroundPlane, FindsTheRoadAmongPointsBesideIt) {
  Road road(60);
  for (size_t i = 0; i < 12; ++i) road.depths[i].depth_m *= 0.6;  // a bonnet in the way
  const auto plane = FitGroundPlane(road.tracks, road.depths);
  ASSERT_TRUE(plane.has_value());
  EXPECT_NEAR(1.0 / plane->norm(), 1.65, 0.03);
  EXPECT_NEAR(plane->normalized().y(), 1.0, 1e-3);
}

TEST(FitGroundPlane, RefusesWhatIsNoPlane) {
  EXPECT_FALSE(FitGroundPlane(Road(5).tracks, Road(5).depths).has_value());
  const Road scattered(60, 1.0);
  EXPECT_FALSE(FitGroundPlane(scattered.tracks, scattered.depths).has_value());
  Road facade(60);
  for (VisualDepth& depth : facade.depths) depth.label = kFirstClusterLabel;
  EXPECT_FALSE(FitGroundPlane(facade.tracks, facade.depths).has_value());
}

TEST(PlaneHomography, TakesPointsOfThePlaneToWhereTheyAreSeen) {
  const Camera camera = TestCamera();
  const Rigid3d T_cur_prev(ExpSo3({0.002, 0.01, -0.003}), Eigen::Vector3d(0.05, 0.01, -3.5));
  const cv::Matx33d H = PlaneHomography(Eigen::Vector3d(0.0, 1.0 / 1.65, 0.0), T_cur_prev, camera);
  for (const double z : {6.0, 12.0, 30.0}) {
    const Eigen::Vector3d p(2.0, 1.65, z);
    const Eigen::Vector2d before = camera.Project(p.hnormalized());
    const Eigen::Vector2d after = camera.Project((T_cur_prev * p).hnormalized());
    const cv::Vec3d mapped = H * cv::Vec3d(before.x(), before.y(), 1.0);
    EXPECT_NEAR(mapped[0] / mapped[2], after.x(), 1e-6);
    EXPECT_NEAR(mapped[1] / mapped[2], after.y(), 1e-6);
  }
}

// The road at 35 m/s: 3.5 m a frame. The prediction is off by half a metre.
TEST(GroundWarp, RoadIsFollowedAtHighwaySpeed) {
  const Camera camera = TestCamera();
  const Eigen::Vector3d plane(0.0, 1.0 / 1.65, 0.0);
  const auto moved = [](double z_m) { return Rigid3d::Translation(0.0, 0.0, -z_m); };
  const cv::Mat before = MakeTexture({1242, 375}, 21);
  cv::Mat after;
  cv::warpPerspective(before, after, PlaneHomography(plane, moved(3.5), camera), before.size(),
                      cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  const auto followed = [&](bool with_warp) {
    FeatureTracker tracker;
    const FeatureTracks first = tracker.Track(before, camera);
    VisualDepths depths;
    for (const FeatureTrack& track : first.tracks) {
      const double depth_m = 1.65 / std::max(1e-3, track.ray_cam.y());
      const bool is_road = track.ray_cam.y() > 0.04;
      depths.push_back({is_road ? DepthStatus::kOk : DepthStatus::kTooFar, depth_m, 0.05,
                        with_warp ? kLabelGround : kFirstClusterLabel});
    }
    const FeatureTracks second =
        tracker.Track(after, camera, PredictPixels(first, depths, moved(3.0), camera));
    int right = 0;
    for (const FeatureTrack& track : second.tracks) {
      if (track.length != 2) continue;
      const Eigen::Vector3d ray_prev = camera.Unproject(track.px_cam_prev).homogeneous();
      if (ray_prev.y() < 0.04) continue;
      const Eigen::Vector3d p = 1.65 / ray_prev.y() * ray_prev;
      const Eigen::Vector2d wanted = camera.Project((moved(3.5) * p).hnormalized());
      right += (track.px_cam - wanted).norm() < 0.5;
    }
    return right;
  };
  EXPECT_GT(followed(true), 40);
  EXPECT_GT(followed(true), 2 * followed(false));
}

}  // namespace
}  // namespace tvl
