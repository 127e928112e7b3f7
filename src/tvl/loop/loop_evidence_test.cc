#include "tvl/loop/loop_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/geometry/point_index.h"
#include "tvl/loop/seen_ranges.h"
#include "tvl/loop/test_passes.h"

namespace tvl {
namespace {

using synthetic::Passes;

TEST(TrimmedRms, IsThatOfTheBest) {
  EXPECT_DOUBLE_EQ(TrimmedRms_m({}, 0.8), 0.0);
  EXPECT_DOUBLE_EQ(TrimmedRms_m({100.0, 3.0, 1.0, 1.0, 3.0}, 0.8), std::sqrt(20.0 / 4.0));
  EXPECT_DOUBLE_EQ(TrimmedRms_m({2.0, 4.0}, 1.0), std::sqrt(10.0));
}

struct Fixture {
  Passes passes =
      synthetic::TwoPasses(synthetic::RandomHouses(1), synthetic::RandomHouses(1), false);
  LoopSubmapOptions submap_options;
  LoopSubmap submap{submap_options};
  LoopSource source;
  Rigid3d T_odom_current;  // true

  Fixture() {
    submap.MoveTo(20, 41, passes.T_odom_lidar, passes.Source(), Executor(1));
    source = AssembleSource(56, passes.T_odom_lidar, passes.Source(), {});
    T_odom_current = passes.T_odom_lidar[20] * passes.Truth_T_history_current(20, 56);
  }
};

TEST(LoopEvidence, IsItsDefinition) {
  const Fixture f;
  const Rigid3d T = f.T_odom_current * Rigid3d::Translation(0.4, 0.1, 0.05);
  const LoopEvidence evidence = MeasureEvidence(f.source, f.submap, T, {});

  std::vector<double> all, raised;
  for (size_t i = 0; i < f.source.planes.size(); ++i) {
    const Eigen::Vector3d p = T * f.source.planes[i].cast<double>();
    if (!f.submap.CouldSee(p)) continue;
    const Surfel* s = f.submap.planes().Find(p);
    const double d = s == nullptr ? 1.0 : std::min(1.0, std::abs((p - s->mean).dot(s->axis)));
    all.push_back(d);
    if (f.source.plane_is_raised[i] != 0) raised.push_back(d);
  }
  EXPECT_EQ(evidence.planes, static_cast<int>(all.size()));
  EXPECT_LT(evidence.planes, static_cast<int>(f.source.planes.size()));
  EXPECT_DOUBLE_EQ(evidence.rms_m, TrimmedRms_m(all, 0.8));
  EXPECT_DOUBLE_EQ(evidence.raised_rms_m, TrimmedRms_m(raised, 0.8));

  std::set<std::tuple<double, double, double>> occupied;
  for (const Eigen::Vector3d& c : f.submap.OccupiedCentres()) {
    occupied.insert({c.x(), c.y(), c.z()});
  }
  int met = 0, seen = 0, through = 0;
  for (const Eigen::Vector3f& point : f.source.raised) {
    const Eigen::Vector3d p = T * point.cast<double>();
    if (!f.submap.CouldSee(p)) continue;
    ++seen;
    const auto centre = [](double x) { return 0.5 * (std::floor(x / 0.5) + 0.5); };
    const bool is_met = occupied.count({centre(p.x()), centre(p.y()), centre(p.z())}) > 0;
    met += is_met ? 1 : 0;
    through += !is_met && f.submap.SawThrough(p) ? 1 : 0;
  }
  EXPECT_EQ(evidence.fit.raised, seen);
  EXPECT_DOUBLE_EQ(evidence.fit.overlap, static_cast<double>(met) / seen);
  EXPECT_DOUBLE_EQ(evidence.fit.seen_through, static_cast<double>(through) / seen);
}

TEST(LoopEvidence, TheTruthFitsAndAShiftDoesNot) {
  const Fixture f;
  const LoopEvidence truth = MeasureEvidence(f.source, f.submap, f.T_odom_current, {});
  EXPECT_LT(truth.rms_m, 0.05);
  EXPECT_LT(truth.raised_rms_m, 0.1);
  EXPECT_GT(truth.fit.overlap, 0.8);
  const Rigid3d T_shifted = f.T_odom_current * Rigid3d::Translation(5.0, 0.5, 0.0);
  const LoopEvidence shifted = MeasureEvidence(f.source, f.submap, T_shifted, {});
  EXPECT_GT(shifted.raised_rms_m, 2.0 * truth.raised_rms_m);
  EXPECT_LT(shifted.fit.overlap, 0.4);
  EXPECT_GT(shifted.fit.seen_through, 3.0 * truth.fit.seen_through);
  EXPECT_LT(shifted.rms_m, shifted.raised_rms_m) << "the ground fits everywhere";
}

TEST(LoopEvidence, OfAPlaceNeverSeenThereIsNone) {
  const Fixture f;
  const Rigid3d T_far = f.T_odom_current * Rigid3d::Translation(0.0, 400.0, 0.0);
  const LoopEvidence evidence = MeasureEvidence(f.source, f.submap, T_far, {});
  EXPECT_EQ(evidence.planes, 0);
  EXPECT_EQ(evidence.fit.raised, 0);
  EXPECT_EQ(evidence.fit.overlap, 0.0);
}

TEST(SeenRanges, AreTheFurthestInEachDirection) {
  KeyframeCloud cloud;
  cloud.planes.points = {
      {10.0f, 0.1f, 0.05f}, {10.4f, 0.1f, 0.05f}, {9.0f, 0.1f, 0.05f}, {-3.0f, 4.0f, -1.0f}};
  cloud.edges.points = {{0.0f, -7.0f, 0.0f}};
  const SeenRanges seen(cloud);
  EXPECT_NEAR(seen.Towards({5.0f, 0.05f, 0.025f}), 10.4, 0.01);
  EXPECT_NEAR(seen.Towards({-30.0f, 40.0f, -10.0f}), std::sqrt(26.0), 0.01);
  EXPECT_NEAR(seen.Towards({0.0f, -1.0f, 0.0f}), 7.0, 0.01);
  EXPECT_EQ(seen.Towards({5.0f, 5.0f, 0.0f}), 0.0f) << "nothing measured there";
  EXPECT_EQ(seen.Towards({5.0f, 0.4f, 0.025f}), 0.0f) << "3.4 degrees beside";
  EXPECT_EQ(seen.Towards({0.0f, 0.0f, 5.0f}), 0.0f) << "straight up";
  EXPECT_EQ(seen.Towards({1.0f, 0.0f, 5.0f}), 0.0f) << "steeper than any lidar looks";
}

TEST(LoopSubmapView, KnowsWhatHousesHide) {
  const Fixture f;
  const auto seen = [&](double x, double y, double z) { return f.submap.CouldSee({x, y, z}); };
  EXPECT_TRUE(seen(30.0, 0.5, -1.7)) << "the lane";
  EXPECT_FALSE(seen(30.0, 45.0, -1.0)) << "far behind the houses";
  EXPECT_TRUE(f.submap.SawThrough({30.0, 0.5, 0.0})) << "air";
  EXPECT_FALSE(f.submap.SawThrough({30.0, 0.5, -3.0})) << "below the road";
  EXPECT_FALSE(seen(30.0, 0.0, 20.0)) << "the sky";
}

TEST(LoopSource, PutsTheStretchIntoTheCurrentFrame) {
  const Fixture f;
  LoopSourceOptions alone;
  alone.keyframes_back = 0;
  const LoopSource one = AssembleSource(56, f.passes.T_odom_lidar, f.passes.Source(), alone);
  EXPECT_GT(f.source.raised.size(), one.raised.size());
  const Rigid3d T_world_current = f.passes.T_world_lidar[56];
  int on_ground = 0;
  for (size_t i = 0; i < f.source.planes.size(); ++i) {
    const Eigen::Vector3d p = T_world_current * f.source.planes[i].cast<double>();
    const bool is_ground = std::abs(p.z() + 1.7) < 0.15;
    on_ground += is_ground ? 1 : 0;
    EXPECT_TRUE(!is_ground || f.source.plane_is_raised[i] == 0);
    EXPECT_TRUE(std::abs(p.y()) > 2.0 || is_ground) << "the lane is free: " << p.transpose();
  }
  EXPECT_GT(on_ground, 300);
  std::vector<Eigen::Vector3f> seen;  // by keyframes 46, 48 ... 56, at their true poses
  for (size_t k = 46; k <= 56; k += 2) {
    for (const auto* cloud : {&f.passes.clouds[k]->planes, &f.passes.clouds[k]->edges}) {
      for (const Eigen::Vector3f& point : cloud->points) {
        seen.push_back((f.passes.T_world_lidar[k] * point.cast<double>()).cast<float>());
      }
    }
  }
  const PointIndex index(seen);
  for (const Eigen::Vector3f& point : f.source.raised) {
    const Eigen::Vector3d p = T_world_current * point.cast<double>();
    EXPECT_GT(p.z(), -1.2);
    Neighbour nearest;
    ASSERT_EQ(index.Nearest(p.cast<float>(), 1, &nearest), 1u);
    EXPECT_LT(nearest.distance_sq_m2, 1e-4f) << p.transpose();
  }
}

TEST(LoopSource, ReachesBackNoFurtherThanTheFirstKeyframe) {
  const Fixture f;
  const LoopSource source = AssembleSource(0, f.passes.T_odom_lidar, f.passes.Source(), {});
  EXPECT_FALSE(source.planes.empty());
  EXPECT_THROW(AssembleSource(57, f.passes.T_odom_lidar, f.passes.Source(), {}), Error);
}

}  // namespace
}  // namespace tvl
