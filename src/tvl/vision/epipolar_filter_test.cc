#include "tvl/vision/epipolar_filter.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {
namespace {

struct Pairs {
  std::vector<Eigen::Vector2d> previous, current;
};

// `count` points 4..40 m ahead seen before and after T_cur_prev, with noise.
Pairs Observe(const Rigid3d& T_cur_prev, int count, double noise_px) {
  Rng rng(17);
  Pairs pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d ray(rng.Uniform(-0.8, 0.8), rng.Uniform(-0.25, 0.25));
    const Eigen::Vector3d p = rng.Uniform(4.0, 40.0) * ray.homogeneous();
    const Eigen::Vector2d noise(rng.Normal(), rng.Normal());
    pairs.previous.push_back(ray);
    pairs.current.push_back((T_cur_prev * p).hnormalized() + noise_px / 460.0 * noise);
  }
  return pairs;
}

const Rigid3d kForward =
    Rigid3d::Exp((Vector6d() << 0.002, 0.03, 0.001, 0.02, 0.01, -1.0).finished());

int Count(const std::vector<bool>& inlier, size_t begin, size_t end) {
  return static_cast<int>(std::accumulate(inlier.begin() + static_cast<std::ptrdiff_t>(begin),
                                          inlier.begin() + static_cast<std::ptrdiff_t>(end), 0));
}

TEST(EpipolarFilter, KeepsARigidSceneAndRejectsOutliers) {
  Pairs pairs = Observe(kForward, 300, 0.15);
  for (size_t i = 0; i < 75; ++i) pairs.current[i].y() += (i % 2 ? 1.0 : -1.0) * 15.0 / 460.0;
  for (size_t i = 0; i < 75; ++i) pairs.current[i].x() += (i % 3 ? 1.0 : -1.0) * 15.0 / 460.0;
  const std::vector<bool> inlier =
      EpipolarInliers(pairs.previous, pairs.current, EpipolarFilterOptions());
  EXPECT_LT(Count(inlier, 0, 75), 12);  // some move along their epipolar line: no test sees it
  EXPECT_GT(Count(inlier, 75, 300), 220);
}

TEST(EpipolarFilter, PassesEverythingAtStandstill) {
  const Pairs pairs = Observe(Rigid3d(), 200, 0.65);  // of noise alone a model is soon made
  EpipolarFilterOptions options;
  EXPECT_EQ(Count(EpipolarInliers(pairs.previous, pairs.current, options), 0, 200), 200);
}

TEST(EpipolarFilter, PureRotationKeepsNearlyAll) {
  const Rigid3d turn = Rigid3d::Exp((Vector6d() << 0, 0.05, 0, 0, 0, 0).finished());
  const Pairs pairs = Observe(turn, 200, 0.15);
  EXPECT_GT(Count(EpipolarInliers(pairs.previous, pairs.current, {}), 0, 200), 190);
}

TEST(EpipolarFilter, FewPointsPass) {
  const Pairs pairs = Observe(kForward, 9, 0.0);
  EXPECT_EQ(Count(EpipolarInliers(pairs.previous, pairs.current, {}), 0, 9), 9);
  EXPECT_TRUE(EpipolarInliers({}, {}, {}).empty());
}

TEST(EpipolarFilter, SameInputSameAnswer) {
  const Pairs pairs = Observe(kForward, 300, 0.5);
  EXPECT_EQ(EpipolarInliers(pairs.previous, pairs.current, {}),
            EpipolarInliers(pairs.previous, pairs.current, {}));
}

}  // namespace
}  // namespace tvl
