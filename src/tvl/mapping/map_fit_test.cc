#include "tvl/mapping/map_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include <numeric>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr double kStreet_m = 60.0;

// A street along x from -kStreet_m to 0: ground, two walls with pillars every 7 m.
std::vector<Eigen::Vector3f> StreetPoints(uint64_t seed, bool with_ground) {
  Rng rng(seed);
  std::vector<Eigen::Vector3f> points;
  const auto add = [&](double x, double y, double z) {
    points.emplace_back(static_cast<float>(x + 0.02 * rng.Normal()),
                        static_cast<float>(y + 0.02 * rng.Normal()),
                        static_cast<float>(z + 0.02 * rng.Normal()));
  };
  for (double x = -kStreet_m; x < 0.0; x += 0.25) {
    for (const double side : {-6.0, 6.0}) {
      for (double z = 0.0; z < 3.0; z += 0.3) add(x, side, z);
    }
    if (!with_ground) continue;
    for (double y = -6.0; y < 6.0; y += 0.5) add(x, y, -1.7);
  }
  for (double x = -kStreet_m + 2.0; x < 0.0; x += 7.0) {
    for (const double side : {-1.0, 1.0}) {
      for (double z = 0.0; z < 3.0; z += 0.15) {
        for (double d = 0.0; d < 1.0; d += 0.1) add(x, side * (5.0 + d), z);
      }
    }
  }
  return points;
}

LocalMap Street(const Executor& executor) {
  LocalMap map{LocalMapOptions()};
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = StreetPoints(1, true);
  cloud->planes.intensity.assign(cloud->planes.points.size(), 0.5f);
  map.Add({0, 0.0, Rigid3d(), cloud}, executor);
  return map;
}

MapFit FitAt(const LocalMap& map, double x_m) {
  const std::vector<Eigen::Vector3f> points = StreetPoints(2, false);
  std::vector<FitSample> sample;
  for (uint32_t i = 0; i < points.size(); ++i) sample.push_back({i, kLabelOutlier});
  return FitToMap(points, sample, map, Rigid3d::Translation(x_m, 0.0, 0.0), MapFitOptions());
}

TEST(MapFit, TellsTheRightPoseFromOneAlongTheStreet) {
  const Executor executor(1);
  const LocalMap map = Street(executor);
  const MapFit right = FitAt(map, 0.0);
  EXPECT_LT(right.mean, 0.1);
  for (const double off_m : {-3.0, -1.0, 1.0, 3.0}) {
    const FitComparison comparison = Compare(right, FitAt(map, off_m));
    EXPECT_GT(comparison.better, 3.0 * comparison.standard_error) << off_m;
  }
}

// Half of the scan shows what the map has not seen: it is not judged, and the right pose still lies
// better than one that stays behind.
TEST(MapFit, TheUnknownAheadIsNotHeldAgainstAPose) {
  const Executor executor(1);
  const LocalMap map = Street(executor);
  const MapFit ahead = FitAt(map, 28.0);  // four pillars further on
  EXPECT_LT(ahead.mean, 0.15);
  EXPECT_LT(ahead.judged, 0.7 * static_cast<double>(ahead.cost.size()));
  const FitComparison comparison = Compare(ahead, FitAt(map, 25.0));
  EXPECT_GT(comparison.better, 3.0 * comparison.standard_error);
}

TEST(Evidence, CountsPointsOnTheMapAgainstPointsOffIt) {
  MapFit fit;
  for (int i = 0; i < 160; ++i) {
    fit.cost.push_back(i % 4 == 0 ? 1.0f : 0.0f);
    fit.weight.push_back(0.5f);
  }
  fit.judged = 80.0;
  fit.mean = 0.25;
  EXPECT_NEAR(Evidence(fit), 60.0 - 20.0, 1e-9);
  // By hand: each point's 1 - 2 c has the variance 0.75, a quarter of it after the weight, and four
  // neighbours count as one.
  EXPECT_NEAR(EvidenceSigmas(fit), 40.0 / std::sqrt(4.0 * 160.0 * 0.25 * 0.75 + 16.0), 1e-9);
  MapFit nothing;
  EXPECT_EQ(EvidenceSigmas(nothing), 0.0);
}

// Where the map knows more, a pose has more to show for itself, for or against it.
TEST(Evidence, SpeaksForTheRightPoseAndAgainstOthers) {
  const Executor executor(1);
  const LocalMap map = Street(executor);
  EXPECT_GT(EvidenceSigmas(FitAt(map, 0.0)), 5.0);
  EXPECT_GT(EvidenceSigmas(FitAt(map, 28.0)), 3.0) << "half of it is unknown";
  EXPECT_LT(Evidence(FitAt(map, 28.0)), Evidence(FitAt(map, 0.0)));
  for (const double off_m : {-3.0, 3.0}) {
    EXPECT_LT(Evidence(FitAt(map, off_m)), 0.5 * Evidence(FitAt(map, 0.0))) << off_m;
  }
}

TEST(MapFit, EqualPosesAreNoBetter) {
  const Executor executor(1);
  const LocalMap map = Street(executor);
  const MapFit fit = FitAt(map, 0.0);
  EXPECT_EQ(Compare(fit, fit).better, 0.0);
}

TEST(FitWithoutNewClusters, LeavesOutClustersThatLieOffTheMapAsAWhole) {
  MapFit fit;
  const auto add = [&](int32_t label, float cost, int count) {
    fit.cost.insert(fit.cost.end(), static_cast<size_t>(count), cost);
    fit.weight.insert(fit.weight.end(), static_cast<size_t>(count), 1.0f);
    fit.label.insert(fit.label.end(), static_cast<size_t>(count), label);
  };
  add(5, 0.9f, 300);  // a lorry
  add(6, 0.1f, 100);  // a facade
  add(7, 0.9f, 4);    // too few to be called a thing
  add(kLabelOutlier, 0.9f, 20);
  const KnownFit known = FitWithoutNewClusters(fit);
  EXPECT_EQ(known.new_clusters, std::set<int32_t>({5}));
  EXPECT_NEAR(known.judged, 124.0, 1e-6);
  EXPECT_NEAR(known.mean, (0.1 * 100 + 0.9 * 24) / 124.0, 1e-5);
}

// Both hypotheses leave the lorry off the map: it does not count, whatever it adds to either.
TEST(Compare, WhatNeitherExplainsSaysNothing) {
  MapFit right, wrong;
  for (int i = 0; i < 400; ++i) {
    const bool is_lorry = i < 300;
    right.cost.push_back(is_lorry ? 1.0f : 0.05f);
    wrong.cost.push_back(is_lorry ? 0.7f : 0.6f);
    for (MapFit* fit : {&right, &wrong}) {
      fit->weight.push_back(1.0f);
      fit->label.push_back(is_lorry ? 5 : kLabelOutlier);
    }
  }
  const FitComparison comparison = Compare(right, wrong);
  EXPECT_NEAR(comparison.better, 0.55, 1e-3);
  EXPECT_NEAR(comparison.common, 100.0, 1e-6);
}

TEST(SampleForFit, TakesWhatStandsEvenlyFromTheWholeScan) {
  std::vector<LaserFeature> features(10000);
  for (size_t i = 0; i < features.size(); ++i) {
    features[i].p_lidar = {i % 10 == 0 ? 70.0f : 10.0f, 0.0f, 0.0f};
    features[i].label = i % 2 == 0 ? kLabelGround : kFirstClusterLabel;
  }
  const MapFitOptions options;
  const std::vector<FitSample> sample = SampleForFit(features, options);
  ASSERT_EQ(sample.size(), static_cast<size_t>(options.max_points));
  EXPECT_LT(sample.front().index, 20u);
  EXPECT_GT(sample.back().index, 9950u);
  for (const FitSample& point : sample) EXPECT_EQ(features[point.index].label, kFirstClusterLabel);
}

TEST(MapFitOptions, NameTheBadField) {
  MapFitOptions options;
  options.max_distance_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
