#include "tvl/odometry/road_motion.h"

#include <gtest/gtest.h>

#include <set>

#include "tvl/base/rng.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

constexpr double kHeight_m = 1.73;

// Two images of a road, seen from a vehicle that moves by T; the points in `carried` move with the
// vehicle, as the shadow of the car before it does.
struct Road {
  VisualFeatures previous, current;
  Calibration calibration = synthetic::CameraAndLidar();

  Road(int tracks, const Rigid3d& T_prev_cur, const std::set<int>& carried = {},
       double noise_px = 0.2) {
    Rng rng(7, 1);
    for (int id = 0; id < tracks; ++id) {
      const Eigen::Vector3d p(rng.Uniform(6.0, 11.0), rng.Uniform(-4.0, 4.0), -kHeight_m);
      const bool moves_along = carried.count(id) > 0;
      Add(id, p, 0.0, &previous, nullptr);
      Add(id, moves_along ? p : T_prev_cur.Inverse() * p, noise_px, &current, &rng);
    }
  }

  void Add(TrackId id, const Eigen::Vector3d& p_lidar, double noise_px, VisualFeatures* features,
           Rng* rng) const {
    const Eigen::Vector3d p_cam = calibration.T_cam_lidar * p_lidar;
    Eigen::Vector2d ray = p_cam.hnormalized();
    const double sigma = noise_px / calibration.camera.fx_px;
    if (rng != nullptr) ray += sigma * Eigen::Vector2d(rng->Normal(), rng->Normal());
    const Eigen::Vector2d px = calibration.camera.Project(ray);
    features->tracks.tracks.push_back({id, 2, px, px, ray});
    features->depths.push_back({DepthStatus::kOk, p_cam.z(), 0.02, kLabelGround});
  }

  std::optional<RoadMotion> Measure(const RoadGuess& guess = {}) const {
    return MeasureRoadMotion(previous, current, calibration, guess, RoadMotionOptions());
  }
};

std::set<int> First(int count) {
  std::set<int> ids;
  for (int id = 0; id < count; ++id) ids.insert(id);
  return ids;
}

Rigid3d Forward(double x_m) { return Rigid3d::Translation(x_m, 0.01, 0.0); }

TEST(RoadMotion, IsFoundWithoutAGuess) {
  for (const double x_m : {0.0, 0.05, 0.5, 1.5}) {
    const auto motion = Road(40, Forward(x_m)).Measure();
    ASSERT_TRUE(motion.has_value()) << x_m;
    EXPECT_NEAR(motion->T_prev_cur.t().x(), x_m, 0.02);
    EXPECT_NEAR(motion->T_prev_cur.t().y(), 0.01, 0.01);
    EXPECT_LT(std::sqrt(motion->covariance_m2(0, 0)), 0.02);
    EXPECT_EQ(motion->tracks, 40);
  }
}

TEST(RoadMotion, ShadowsThatKeepPaceDoNotStopIt) {
  const auto motion = Road(40, Forward(0.5), First(15)).Measure();
  ASSERT_TRUE(motion.has_value());
  EXPECT_NEAR(motion->T_prev_cur.t().x(), 0.5, 0.02);
  for (const size_t i : motion->agreeing) EXPECT_GE(i, 15u) << "a shadow";
}

TEST(RoadMotion, WhatIsExpectedDecidesACloseCall) {
  const Road road(40, Forward(0.5), First(20));
  RoadGuess guess;
  guess.information = Eigen::Matrix2d::Identity() / (0.05 * 0.05);
  guess.expected_m = {0.47, 0.0};
  const auto as_before = road.Measure(guess);
  ASSERT_TRUE(as_before.has_value());
  EXPECT_NEAR(as_before->T_prev_cur.t().x(), 0.5, 0.02);
  guess.expected_m = {0.0, 0.0};
  const auto standing = road.Measure(guess);
  ASSERT_TRUE(standing.has_value());
  EXPECT_NEAR(standing->T_prev_cur.t().x(), 0.0, 0.02);
}

TEST(RoadMotion, IsNotKnownFromAFewTracksNorFromScatteredOnes) {
  EXPECT_FALSE(Road(6, Forward(0.5)).Measure().has_value());
  EXPECT_FALSE(Road(40, Forward(0.5), {}, 60.0).Measure().has_value());
}

TEST(RoadMotion, OnlyTheGroundCounts) {
  Road road(40, Forward(0.5));
  for (VisualDepth& depth : road.previous.depths) depth.label = kFirstClusterLabel;
  EXPECT_FALSE(road.Measure().has_value());
}

}  // namespace
}  // namespace tvl
