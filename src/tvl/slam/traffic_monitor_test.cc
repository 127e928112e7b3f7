#include "tvl/slam/traffic_monitor.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

std::optional<StandingMotion> Road(double x_m) {
  return StandingMotion{Rigid3d::Translation(x_m, 0.0, 0.0), Eigen::Matrix2d::Zero(), false};
}

constexpr double kPeriod_s = 0.1;

Rigid3d Scan(double x_m) { return Rigid3d::Translation(x_m, 0.0, 0.0); }

TEST(TrafficMonitor, NoticesASteadySlip) {
  TrafficMonitor monitor{TrafficOptions()};
  double slip_m = 0.0;
  int frames = 0;
  while (!monitor.carries_estimate() && frames < 20) {
    slip_m = monitor.Update(Scan(0.08), Road(0.10), kPeriod_s).norm();
    ++frames;
  }
  EXPECT_TRUE(monitor.carries_estimate());
  EXPECT_LE(frames, 5);
  EXPECT_NEAR(slip_m, 0.02 * frames, 1e-9);
}

TEST(TrafficMonitor, TakesNoiseForNoSlip) {
  TrafficMonitor monitor{TrafficOptions()};
  for (int k = 0; k < 200; ++k)
    monitor.Update(Scan(0.10 + (k % 2 == 0 ? 0.015 : -0.015)), Road(0.10), kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate());
}

TEST(TrafficMonitor, FastTrafficIsNoJam) {
  TrafficMonitor monitor{TrafficOptions()};
  for (int k = 0; k < 20; ++k) monitor.Update(Scan(0.7), Road(1.0), kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate());
}

TEST(TrafficMonitor, ARoadThatIsNotSeenSaysNothing) {
  TrafficMonitor monitor{TrafficOptions()};
  for (int k = 0; k < 20; ++k) monitor.Update(Scan(0.0), std::nullopt, kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate());
}

TEST(TrafficMonitor, OneLeapIsNoSlip) {
  TrafficMonitor monitor{TrafficOptions()};
  for (int k = 0; k < 20; ++k) monitor.Update(Scan(k == 10 ? -0.1 : 0.1), Road(0.1), kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate());
}

TEST(TrafficMonitor, WithoutTheRoadTheScanIsBelievedAgain) {
  TrafficMonitor monitor{TrafficOptions()};
  for (int k = 0; k < 5; ++k) monitor.Update(Scan(0.0), Road(0.2), kPeriod_s);
  EXPECT_TRUE(monitor.carries_estimate());
  for (int k = 0; k < 20; ++k) monitor.Update(Scan(0.0), std::nullopt, kPeriod_s);
  EXPECT_TRUE(monitor.carries_estimate());
  monitor.Update(Scan(0.0), std::nullopt, kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate());
}

TEST(TrafficMonitor, BelievesTheScanAgainAfterALongWay) {
  TrafficMonitor monitor{TrafficOptions()};
  while (!monitor.carries_estimate()) monitor.Update(Scan(0.0), Road(0.2), kPeriod_s);
  // A stand proves nothing: everything stands then.
  for (int k = 0; k < 500; ++k) monitor.Update(Scan(0.0), Road(0.0), kPeriod_s);
  EXPECT_TRUE(monitor.carries_estimate());
  for (int k = 0; k < 90; ++k) monitor.Update(Scan(0.2), Road(0.2), kPeriod_s);
  EXPECT_TRUE(monitor.carries_estimate()) << "18 m";
  for (int k = 0; k < 20; ++k) monitor.Update(Scan(0.2), Road(0.2), kPeriod_s);
  EXPECT_FALSE(monitor.carries_estimate()) << "22 m";
}

TEST(TrafficMonitor, TheFirstMotionTakesALargeMajority) {
  TrafficMonitor monitor{TrafficOptions()};
  RoadMotion road;
  road.T_prev_cur = Rigid3d::Translation(0.3, 0.0, 0.0);
  road.tracks = 40;
  road.agreeing.assign(30, 0);
  EXPECT_TRUE(monitor.Start(Scan(0.0), road, kPeriod_s));
  EXPECT_FALSE(monitor.Start(Scan(0.29), road, kPeriod_s)) << "they agree";
  road.agreeing.resize(15);
  EXPECT_FALSE(monitor.Start(Scan(0.0), road, kPeriod_s)) << "15 of 40";
  road.tracks = 20;
  EXPECT_TRUE(monitor.Start(Scan(0.0), road, kPeriod_s));
  road.agreeing_with_guess = 8;
  EXPECT_FALSE(monitor.Start(Scan(0.0), road, kPeriod_s)) << "8 of 20 say the same as the scan";
}

TEST(TrafficMonitor, WhatStandsBesideTheRoadDecidesInASingleFrame) {
  TrafficMonitor monitor{TrafficOptions()};
  const StandingMotion beside{Rigid3d::Translation(0.3, 0.0, 0.0),
                              Eigen::Matrix2d::Identity() * (0.03 * 0.03), true};
  EXPECT_FALSE(monitor.Contradicts(beside, Scan(0.2))) << "three standard deviations and a slip";
  EXPECT_TRUE(monitor.Contradicts(beside, Scan(0.0)));
  EXPECT_NEAR(monitor.Update(Scan(0.0), beside, kPeriod_s).x(), 0.3, 1e-9);
  EXPECT_TRUE(monitor.carries_estimate());
}

TEST(TrafficMonitor, ARoadOnWhichNearlyAllTracksContradictTheScanDecidesInASingleFrame) {
  RoadMotion road;
  road.T_prev_cur = Rigid3d::Translation(0.2, 0.0, 0.0);
  road.tracks = 10;
  road.agreeing.assign(8, 0);
  TrafficMonitor monitor{TrafficOptions()};
  EXPECT_TRUE(monitor.Contradicts(StandingMotion::Of(road), Scan(0.0)));
  road.agreeing_with_guess = 3;
  EXPECT_FALSE(monitor.Contradicts(StandingMotion::Of(road), Scan(0.0))) << "some go with the scan";
  road.agreeing_with_guess = 0;
  road.tracks = 16;
  EXPECT_FALSE(monitor.Contradicts(StandingMotion::Of(road), Scan(0.0))) << "8 of 16";
}

TEST(TrafficMonitor, TakesTheExpectedOutOfWhatTheSurroundingsSay) {
  const TrafficMonitor monitor{TrafficOptions()};
  MotionPrediction expected;
  expected.T_prev_cur = Rigid3d::Translation(0.1, 0.0, 0.0);
  expected.covariance = Matrix6d::Identity() * (0.05 * 0.05);
  // Measured: 0.3 m, as well as the prediction knows it. Found: in the middle.
  const Matrix6d covariance = 0.5 * expected.covariance;
  const auto beside = monitor.Surroundings(Scan(0.2), covariance, expected);
  ASSERT_TRUE(beside.has_value());
  EXPECT_NEAR(beside->T_prev_cur.t().x(), 0.3, 1e-9);
  EXPECT_NEAR(beside->covariance_m2(0, 0), 0.05 * 0.05, 1e-12);
  EXPECT_FALSE(monitor.Surroundings(Scan(0.1), expected.covariance, expected).has_value())
      << "nothing but what was expected";
  Matrix6d along = covariance;
  along(3, 3) = 0.9 * expected.covariance(3, 3);
  EXPECT_FALSE(monitor.Surroundings(Scan(0.1), along, expected).has_value())
      << "walls along the road tell nothing of the way along it";
}

LaserFeature Feature(float x_m, float y_m, int32_t label) {
  LaserFeature feature;
  feature.p_lidar = {x_m, y_m, 0.0f};
  feature.label = label;
  return feature;
}

TEST(TrafficMonitor, ThingsThatLieOffTheMapInTheCorridorMove) {
  constexpr int32_t kLorry = kFirstClusterLabel, kHouse = kFirstClusterLabel + 1;
  LaserFeatures features;
  MapFit fit;
  for (int i = 0; i < 100; ++i) {
    features.less_flat.push_back(Feature(3.0f, 2.5f, kLorry));
    features.less_flat.push_back(Feature(3.0f, 14.0f, kHouse));
    fit.label.insert(fit.label.end(), {kLorry, kHouse});
    fit.cost.insert(fit.cost.end(), {i < 20 ? 1.0f : 0.0f, 0.0f});
    fit.weight.insert(fit.weight.end(), {1.0f, 1.0f});
  }
  const TrafficMonitor monitor{TrafficOptions()};
  EXPECT_TRUE(monitor.IsAmongMovingThings(features, fit, Scan(0.1), kPeriod_s));
  EXPECT_FALSE(monitor.IsAmongMovingThings(features, fit, Scan(0.7), kPeriod_s)) << "at speed";
  MapFit house = fit, unknown = fit;
  for (size_t i = 0; i < fit.cost.size(); ++i) {
    house.cost[i] = fit.label[i] == kHouse && i < 80 ? 1.0f : 0.0f;
    unknown.weight[i] = 0.2f;
  }
  EXPECT_FALSE(monitor.IsAmongMovingThings(features, house, Scan(0.1), kPeriod_s)) << "beside";
  EXPECT_FALSE(monitor.IsAmongMovingThings(features, unknown, Scan(0.1), kPeriod_s))
      << "the map hardly knows the place";
}

TEST(TrafficMonitor, LeavesTheGroundAndWhatStandsBeside) {
  constexpr int32_t kLorry = kFirstClusterLabel, kHouse = kFirstClusterLabel + 1;
  PreprocessedFrame frame;
  for (auto* features : {&frame.features.sharp, &frame.features.flat, &frame.features.less_sharp,
                         &frame.features.less_flat}) {
    for (int i = 0; i < 5; ++i) {
      features->push_back(Feature(3.0f, 2.5f, kLorry));
      features->push_back(Feature(9.0f, 0.0f, kLabelGround));
      features->push_back(Feature(3.0f, 14.0f, kHouse));
    }
  }
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Zero();
  for (TrackId id = 0; id < 4; ++id) {
    frame.tracks.tracks.push_back({id, 5, nowhere, nowhere, nowhere});
  }
  frame.tracks.tracks.push_back({4, 1, nowhere, nowhere, nowhere});
  frame.depths.resize(5);
  frame.depths[0].label = kLorry;
  frame.depths[1].label = kLabelGround;   // agrees with the road
  frame.depths[2].label = kLabelGround;   // a shadow
  frame.depths[3].label = kLabelOutlier;  // above the lidar's sight
  frame.depths[4].label = kLabelGround;   // seen for the first time
  RoadMotion road;
  road.agreeing = {1};
  EXPECT_EQ(TrafficMonitor{TrafficOptions()}.RemoveTraffic(road, &frame), 3);
  ASSERT_EQ(frame.depths.size(), 2u);
  ASSERT_EQ(frame.tracks.tracks.size(), 2u);
  EXPECT_EQ(frame.tracks.tracks[0].id, 1);
  EXPECT_EQ(frame.tracks.tracks[1].id, 4);
  for (const auto* features : {&frame.features.sharp, &frame.features.flat,
                               &frame.features.less_sharp, &frame.features.less_flat}) {
    ASSERT_EQ(features->size(), 10u);
    for (const LaserFeature& feature : *features) EXPECT_NE(feature.label, kLorry);
  }
}

}  // namespace
}  // namespace tvl
