#include "tvl/slam/health.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// A measured pose whose scan lies on the map with this misfit at `points` well known points.
TrackedPose Pose(double x_m, double misfit, int points = 800) {
  TrackedPose tracked;
  tracked.is_measured = true;
  tracked.T_odom_lidar = Rigid3d::Translation(x_m, 0.0, 0.0);
  tracked.fit.cost.assign(static_cast<size_t>(points), static_cast<float>(misfit));
  tracked.fit.weight.assign(static_cast<size_t>(points), 1.0f);
  tracked.fit.label.assign(static_cast<size_t>(points), kLabelOutlier);
  tracked.fit.judged = points;
  tracked.fit.mean = misfit;
  return tracked;
}

HealthMonitor After(double usual_misfit) {
  HealthMonitor monitor{HealthOptions()};
  for (int k = 0; k < 30; ++k) monitor.Learn(Pose(0.0, usual_misfit));
  return monitor;
}

TEST(HealthMonitor, MisfitIsJudgedAgainstWhatIsUsual) {
  const HealthMonitor street = After(0.05), jam = After(0.3);
  EXPECT_EQ(street.Judge(Pose(0.0, 0.08), Rigid3d(), false), Health::kGood);
  EXPECT_EQ(street.Judge(Pose(0.0, 0.15), Rigid3d(), false), Health::kSuspicious);
  EXPECT_EQ(street.Judge(Pose(0.0, 0.33), Rigid3d(), false), Health::kBad);
  EXPECT_EQ(jam.Judge(Pose(0.0, 0.33), Rigid3d(), false), Health::kGood);
}

TEST(HealthMonitor, ALeapMustLieOnTheMapAsUsual) {
  const HealthMonitor monitor = After(0.05);
  EXPECT_EQ(monitor.Judge(Pose(3.0, 0.06), Rigid3d(), false), Health::kSuspicious);
  EXPECT_EQ(monitor.Judge(Pose(3.0, 0.15), Rigid3d(), false), Health::kBad);
  EXPECT_EQ(monitor.Judge(Pose(3.0, 0.06, 10), Rigid3d(), false), Health::kBad)
      << "nothing about the vehicle can be judged";
  EXPECT_EQ(monitor.Judge(Pose(0.1, 0.06, 10), Rigid3d(), false), Health::kGood);
}

TEST(HealthMonitor, SoMustAnyPoseAfterTheVehicleWasLost) {
  const HealthMonitor monitor = After(0.05);
  EXPECT_EQ(monitor.Judge(Pose(0.0, 0.08), Rigid3d(), true), Health::kGood);
  EXPECT_EQ(monitor.Judge(Pose(0.0, 0.15), Rigid3d(), true), Health::kBad);
}

// A lorry has come to stand beside the vehicle: most points lie off the map, the others as usual.
TrackedPose BesideALorry(double x_m, double known_misfit, int known_points) {
  TrackedPose tracked = Pose(x_m, 0.7);
  tracked.known_fit = {static_cast<double>(known_points), known_misfit, {7}};
  return tracked;
}

TEST(HealthMonitor, WhatCameDoesNotRefuteAPoseThatTheRestBearsOut) {
  const HealthMonitor monitor = After(0.05);
  EXPECT_EQ(monitor.Judge(BesideALorry(0.0, 0.06, 200), Rigid3d(), false), Health::kSuspicious);
  EXPECT_EQ(monitor.Judge(BesideALorry(0.0, 0.3, 200), Rigid3d(), false), Health::kBad);
  EXPECT_EQ(monitor.Judge(BesideALorry(0.0, 0.06, 20), Rigid3d(), false), Health::kBad)
      << "too little is left to tell";
  EXPECT_EQ(monitor.Judge(BesideALorry(2.0, 0.06, 200), Rigid3d(), false), Health::kBad)
      << "a leap needs the whole scan";
  EXPECT_EQ(monitor.Judge(BesideALorry(0.0, 0.06, 200), Rigid3d(), true), Health::kBad);
}

TEST(HealthMonitor, SoDoMostOfTheTracks) {
  const HealthMonitor monitor = After(0.05);
  TrackedPose tracked = BesideALorry(0.0, 0.5, 200);
  tracked.odometry.evidence.visual_offered = 100;
  tracked.odometry.evidence.visual = 80;
  EXPECT_EQ(monitor.Judge(tracked, Rigid3d(), false), Health::kSuspicious);
  tracked.odometry.evidence.visual = 40;
  EXPECT_EQ(monitor.Judge(tracked, Rigid3d(), false), Health::kBad);
}

TEST(HealthMonitor, APoseThatIsConfirmedIsNotReplacedByOneThatIsNot) {
  const HealthMonitor monitor = After(0.05);
  TrackedPose follows_lorry = Pose(1.0, 0.3);
  follows_lorry.known_fit = {300.0, 0.5, {}};
  EXPECT_FALSE(monitor.IsBetter(follows_lorry, BesideALorry(0.0, 0.06, 200), 3.0));
  EXPECT_TRUE(monitor.IsBetter(follows_lorry, BesideALorry(0.0, 0.4, 200), 3.0));
}

TEST(HealthMonitor, WhatWasNotMeasuredIsNoPose) {
  TrackedPose tracked = Pose(0.0, 0.05);
  tracked.is_measured = false;
  EXPECT_EQ(After(0.05).Judge(tracked, Rigid3d(), false), Health::kBad);
}

TEST(HealthMonitor, AHypothesisMustBeClearlyBetter) {
  const HealthMonitor monitor = After(0.05);
  EXPECT_TRUE(monitor.IsBetter(Pose(1.0, 0.05), Pose(0.0, 0.5), 3.0));
  EXPECT_FALSE(monitor.IsBetter(Pose(1.0, 0.05), Pose(0.0, 0.06), 3.0));
  EXPECT_FALSE(monitor.IsBetter(Pose(1.0, 0.05, 20), Pose(0.0, 0.5, 20), 3.0)) << "too few points";
}

TEST(HealthOptions, NameTheBadField) {
  HealthOptions options;
  options.lost_rise = 0.01;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
