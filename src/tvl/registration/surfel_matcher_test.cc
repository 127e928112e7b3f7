#include "tvl/registration/surfel_matcher.h"

#include <gtest/gtest.h>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

// A wall at x = 10 m, 4 m high.
SurfelMap Wall(const Executor& executor) {
  SurfelMap map(SurfelMapOptions{});
  std::vector<Eigen::Vector3f> points;
  Rng rng(1, 1);
  for (int i = 0; i < 4000; ++i) {
    points.emplace_back(10.0 + 0.01 * rng.Normal(), -5.0 + 10.0 * rng.Uniform(),
                        -1.0 + 4.0 * rng.Uniform());
  }
  map.Add(points, Rigid3d(), executor);
  return map;
}

TEST(SurfelMatcher, MatchesWithinTheGateOnly) {
  const Executor executor(1);
  const SurfelMap map = Wall(executor);
  const std::vector<Eigen::Vector3f> points = {
      {9.95F, 0.0F, 0.5F}, {9.6F, 0.0F, 0.5F}, {3.0F, 0.0F, 0.5F}};
  const auto matches = MatchPlanes(points, map, Rigid3d(), 0.2, MatchNoise{}, executor);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].source, 0U);
}

TEST(SurfelMatcher, ALargerErrorIsWorthLess) {
  const Executor executor(1);
  const SurfelMap map = Wall(executor);
  const std::vector<Eigen::Vector3f> points = {{9.95F, 0.0F, 0.5F}};
  const auto sharp = MatchPlanes(points, map, Rigid3d(), 0.2, MatchNoise{0.03}, executor);
  const auto blunt = MatchPlanes(points, map, Rigid3d(), 0.2, MatchNoise{0.3}, executor);
  ASSERT_EQ(sharp.size() + blunt.size(), 2U);
  EXPECT_GT(sharp[0].information, 50.0 * blunt[0].information);
}

}  // namespace
}  // namespace tvl
