#include "tvl/eval/absolute_error.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/eval/test_paths.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

std::vector<Rigid3d> RandomPath(uint64_t seed) {
  Rng rng(seed);
  std::vector<Rigid3d> path;
  for (int i = 0; i < 40; ++i) {
    path.push_back(
        Rigid3d::Translation(rng.Uniform(-50, 50), rng.Uniform(-5, 5), rng.Uniform(-50, 50)));
  }
  return path;
}

TEST(AlignPositions, RecoversAnotherWorldExactly) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const std::vector<Rigid3d> truth = RandomPath(seed);
    Rng rng(seed, 1);
    const Rigid3d T(ExpSo3({rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-1, 1)}),
                    Eigen::Vector3d(rng.Uniform(-9, 9), 100.0, -3.0));
    EXPECT_THAT(AlignPositions(truth, Moved(truth, T.Inverse())), Rigid3dNear(T, 1e-9, 1e-7));
  }
}

TEST(AlignPositions, NeverMirrorsAndNeverScales) {
  const std::vector<Rigid3d> truth = RandomPath(4);
  std::vector<Rigid3d> mirrored;
  for (const Rigid3d& pose : truth) {
    mirrored.push_back(Rigid3d::Translation(-pose.t().x(), pose.t().y(), pose.t().z()));
  }
  // The best rotation: every small step from it is worse.
  const Rigid3d T = AlignPositions(truth, mirrored);
  const auto rmse_m = [&](const Rigid3d& T_truth_estimate) {
    return SummariseErrors(PositionErrors_m(truth, mirrored, T_truth_estimate)).rmse_m;
  };
  EXPECT_GT(rmse_m(T), 1.0);
  for (int i = 0; i < 6; ++i) {
    for (const double step : {-1e-3, 1e-3}) {
      EXPECT_GT(rmse_m(T * Rigid3d::Exp(step * Vector6d::Unit(i))), rmse_m(T)) << i;
    }
  }
  const std::vector<Rigid3d> large = Scaled(truth, 1.1);
  EXPECT_GT(SummariseErrors(PositionErrors_m(truth, large, AlignPositions(truth, large))).rmse_m,
            1.0);
}

TEST(AbsoluteError, GoldenStraightLineScaleError) {
  // Positions 0, 1, 2 against 0, 1.3, 2.6. Aligned, the middles agree: errors 0.3, 0, 0.3. From the
  // first pose: 0, 0.3, 0.6.
  const std::vector<Rigid3d> truth = ConstantMotion(3, 1.0, 0.0);
  const std::vector<Rigid3d> estimate = Scaled(truth, 1.3);
  const AbsoluteError aligned =
      SummariseErrors(PositionErrors_m(truth, estimate, AlignPositions(truth, estimate)));
  EXPECT_NEAR(aligned.rmse_m, std::sqrt(0.18 / 3.0), 1e-12);
  EXPECT_NEAR(aligned.max_m, 0.3, 1e-12);
  const AbsoluteError first =
      SummariseErrors(PositionErrors_m(truth, estimate, AlignFirstPose(truth, estimate)));
  EXPECT_NEAR(first.rmse_m, std::sqrt(0.45 / 3.0), 1e-12);
  EXPECT_NEAR(first.mean_m, 0.3, 1e-12);
  EXPECT_NEAR(first.median_m, 0.3, 1e-12);
}

TEST(AlignFirstPose, UsesTheOrientationToo) {
  const std::vector<Rigid3d> truth = ConstantMotion(30, 1.0, 0.05);
  const Rigid3d T(ExpSo3({0.5, 1.0, 0.0}), Eigen::Vector3d(1, 2, 3));
  const std::vector<Rigid3d> estimate = Moved(truth, T);
  EXPECT_THAT(AlignFirstPose(truth, estimate), Rigid3dNear(T.Inverse(), 1e-9, 1e-9));
  EXPECT_THROW(AlignPositions(truth, {}), Error);
}

}  // namespace
}  // namespace tvl
