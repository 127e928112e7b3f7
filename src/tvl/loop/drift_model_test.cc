#include "tvl/loop/drift_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;

// Distances between all pairs of the first `count` keyframes, by Floyd and Warshall.
std::vector<std::vector<double>> AllPairs(const std::vector<double>& path_m,
                                          const std::vector<LoopLink>& loops, size_t count) {
  const double far = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> d(count, std::vector<double>(count, far));
  for (size_t k = 0; k < count; ++k) {
    d[k][k] = 0.0;
    if (k > 0) d[k][k - 1] = d[k - 1][k] = path_m[k] - path_m[k - 1];
  }
  for (const LoopLink& loop : loops) {
    const size_t a = static_cast<size_t>(loop.from), b = static_cast<size_t>(loop.to);
    if (a < count && b < count) d[a][b] = d[b][a] = 0.0;
  }
  for (size_t m = 0; m < count; ++m) {
    for (size_t a = 0; a < count; ++a) {
      for (size_t b = 0; b < count; ++b) d[a][b] = std::min(d[a][b], d[a][m] + d[m][b]);
    }
  }
  return d;
}

TEST(LinkedPath, MatchesFloydWarshall) {
  Rng rng(3);
  for (int trial = 0; trial < 40; ++trial) {
    const int n = 2 + static_cast<int>(rng.Integer(40));
    std::vector<double> path_m{0.0};
    for (int k = 1; k < n; ++k) path_m.push_back(path_m.back() + rng.Uniform(0.0, 3.0));
    std::vector<LoopLink> loops;
    for (int64_t l = rng.Integer(6); l > 0; --l) {
      loops.push_back({static_cast<int>(rng.Integer(n)), static_cast<int>(rng.Integer(n))});
    }
    const int current = static_cast<int>(rng.Integer(n));
    const size_t count = static_cast<size_t>(current) + 1;
    const std::vector<double> expected = AllPairs(path_m, loops, count)[count - 1];
    EXPECT_THAT(LinkedPath(path_m, loops, current), Pointwise(DoubleNear(1e-9), expected));
  }
}

TEST(LinkedPath, LoopTakesDriftAway) {
  // There and back: 100 m out, 100 m home, and the ends are joined.
  const std::vector<double> path_m{0, 50, 100, 150, 200};
  EXPECT_THAT(LinkedPath(path_m, {}, 4), ::testing::ElementsAre(200, 150, 100, 50, 0));
  EXPECT_THAT(LinkedPath(path_m, {{0, 4}}, 4), ::testing::ElementsAre(0, 50, 100, 50, 0));
  EXPECT_EQ(LinkedPath(path_m, {{4, 0}}, 4), LinkedPath(path_m, {{0, 4}}, 4));
}

TEST(LinkedPath, FutureLinksAreNotFollowed) {
  // By way of keyframe 4, 0 and 2 would be one.
  const std::vector<double> path_m{0, 50, 100, 150, 200};
  EXPECT_THAT(LinkedPath(path_m, {{0, 4}, {2, 4}}, 3), ::testing::ElementsAre(150, 100, 50, 0));
}

TEST(LinkedPath, BrokenContracts) {
  EXPECT_THROW(LinkedPath({0.0, 1.0}, {}, 2), Error);
  EXPECT_THROW(LinkedPath({0.0, 1.0}, {{0, 2}}, 1), Error);
  EXPECT_THROW(LinkedPath({0.0, 1.0}, {{-1, 0}}, 1), Error);
}

TEST(DriftRadius, LargerOfFloorAndShare) {
  const DriftOptions options;
  EXPECT_DOUBLE_EQ(options.visual().Of(100.0), 20.0);
  EXPECT_DOUBLE_EQ(options.visual().Of(3000.0), 30.0);
  EXPECT_DOUBLE_EQ(options.vicinity().Of(0.0), 10.0);
  EXPECT_DOUBLE_EQ(options.vicinity().Of(3000.0), 15.0);
  EXPECT_DOUBLE_EQ(options.lidar().Of(1000.0), 40.0);
  EXPECT_DOUBLE_EQ(options.lidar().Of(3000.0), 90.0);
}

TEST(DriftOptions, NamesTheField) {
  const auto message = [](double DriftOptions::*field, double value) -> std::string {
    DriftOptions options;
    options.*field = value;
    try {
      options.Check();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message(&DriftOptions::visual_floor_m, 5.0), "");
  EXPECT_THAT(message(&DriftOptions::visual_floor_m, 0.0), HasSubstr("visual_floor_m"));
  EXPECT_THAT(message(&DriftOptions::visual_share, -0.1), HasSubstr("visual_share"));
  EXPECT_THAT(message(&DriftOptions::vicinity_floor_m, -1.0), HasSubstr("vicinity_floor_m"));
  EXPECT_THAT(message(&DriftOptions::vicinity_share, 1.5), HasSubstr("vicinity_share"));
  EXPECT_THAT(message(&DriftOptions::lidar_floor_m, 0.0), HasSubstr("lidar_floor_m"));
  EXPECT_THAT(message(&DriftOptions::lidar_share, 2.0), HasSubstr("lidar_share"));
}

}  // namespace
}  // namespace tvl
