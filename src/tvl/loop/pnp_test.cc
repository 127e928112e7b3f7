#include "tvl/loop/pnp.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

struct Scene {
  int inliers = 60, outliers = 40;
  double history_depths = 1.0, current_depths = 0.0;  // shares
  double noise_rad = 0.001;
};

std::vector<PnpMatch> MakeMatches(const Scene& scene, const Rigid3d& T_hc, uint64_t seed) {
  Rng rng(seed);
  std::vector<PnpMatch> matches;
  const auto noise = [&]() -> Eigen::Vector2d {
    return scene.noise_rad * Eigen::Vector2d(rng.Normal(), rng.Normal());
  };
  for (int i = 0; i < scene.inliers + scene.outliers; ++i) {
    const Eigen::Vector3d p_history =
        rng.Uniform(6.0, 40.0) * Eigen::Vector3d(rng.Uniform(-0.8, 0.8), rng.Uniform(-0.2, 0.2), 1);
    const Eigen::Vector3d p_current = T_hc.Inverse() * p_history;
    PnpMatch m;
    m.ray_history = p_history.head<2>() / p_history.z() + noise();
    m.ray_current = p_current.head<2>() / p_current.z() + noise();
    if (i >= scene.inliers) {
      m.ray_current = {rng.Uniform(-0.8, 0.8), rng.Uniform(-0.2, 0.2)};
    }
    if (rng.Uniform() < scene.history_depths) m.depth_history_m = p_history.z();
    if (rng.Uniform() < scene.current_depths) m.depth_current_m = p_current.z();
    matches.push_back(m);
  }
  return matches;
}

Rigid3d Moved() { return Rigid3d(ExpSo3({0.02, 0.10, -0.01}), {0.6, -0.1, 1.5}); }

void ExpectNear(const PnpResult& result, const Rigid3d& T_hc) {
  ASSERT_EQ(result.status, PnpStatus::kFound) << result.inliers << " of " << result.points;
  const Rigid3d error = T_hc.Inverse() * result.T_history_current;
  EXPECT_LT(error.t().norm(), 0.03);
  EXPECT_LT(error.RotationAngle(), 0.002);
}

TEST(Pnp, FindsThePoseAmongOutliers) {
  for (const uint64_t seed : {1, 2, 3}) {
    const PnpResult result = SolvePnp(MakeMatches({}, Moved(), seed), {});
    ExpectNear(result, Moved());
    EXPECT_EQ(result.points, 100);
    EXPECT_GE(result.inliers, 57);
    EXPECT_LE(result.inliers, 64);
  }
}

TEST(Pnp, UsesTheDepthsOfEitherImage) {
  Scene scene;
  scene.history_depths = 0.0;
  scene.current_depths = 1.0;
  ExpectNear(SolvePnp(MakeMatches(scene, Moved(), 4), {}), Moved());
  // A quarter of the matches on each side: neither alone has 25 inliers.
  scene.inliers = 80;
  scene.history_depths = scene.current_depths = 0.25;
  const PnpResult result = SolvePnp(MakeMatches(scene, Moved(), 5), {});
  ExpectNear(result, Moved());
  EXPECT_LT(result.points, 70);
}

TEST(Pnp, RefinementBeatsASampleOfThree) {
  // With noise of a pixel and a half and all points good, least squares averages it out.
  Scene scene;
  scene.inliers = 300;
  scene.outliers = 0;
  scene.noise_rad = 0.002;
  const PnpResult result = SolvePnp(MakeMatches(scene, Moved(), 6), {});
  ASSERT_EQ(result.status, PnpStatus::kFound);
  EXPECT_LT((Moved().Inverse() * result.T_history_current).t().norm(), 0.02);
}

TEST(Pnp, StrangersGiveNoPose) {
  Scene scene;
  scene.inliers = 0;
  scene.outliers = 150;
  EXPECT_EQ(SolvePnp(MakeMatches(scene, Moved(), 7), {}).status, PnpStatus::kFewInliers);
  scene.inliers = 20;  // fewer than 25
  scene.outliers = 20;
  EXPECT_EQ(SolvePnp(MakeMatches(scene, Moved(), 8), {}).status, PnpStatus::kFewInliers);
  scene.outliers = 0;
  EXPECT_EQ(SolvePnp(MakeMatches(scene, Moved(), 9), {}).status, PnpStatus::kFewPoints);
  EXPECT_EQ(SolvePnp({}, {}).status, PnpStatus::kFewPoints);
}

TEST(Pnp, PointsOnOneSpotAreSurvived) {
  std::vector<PnpMatch> matches(40);
  for (PnpMatch& m : matches) {
    m.ray_history = m.ray_current = {0.1, 0.1};
    m.depth_history_m = 10.0;
  }
  EXPECT_NO_THROW(SolvePnp(matches, {}));
}

TEST(Pnp, IsDeterministic) {
  const auto matches = MakeMatches({}, Moved(), 10);
  const PnpResult a = SolvePnp(matches, {}), b = SolvePnp(matches, {});
  EXPECT_EQ(a.T_history_current.Matrix(), b.T_history_current.Matrix());
  EXPECT_EQ(a.inliers, b.inliers);
}

TEST(Pnp, OptionsAreChecked) {
  PnpOptions options;
  options.min_inliers = 5;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.max_error_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.confidence = 1.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
