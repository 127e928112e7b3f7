#include "tvl/sim/pose_spline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl::sim {
namespace {

Vector6d Step() {
  Vector6d xi;
  xi << 0.01, -0.02, 0.05, 1.0, 0.1, -0.05;
  return xi;
}

std::vector<Rigid3d> ConstantMotion(int count) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < count; ++i) poses.push_back(Rigid3d::Exp(static_cast<double>(i) * Step()));
  return poses;
}

TEST(PoseSplineTest, FollowsAConstantTurn) {
  const PoseSpline spline(ConstantMotion(12), 1.0, 0.1);
  for (double f = 1.0; f <= 10.0; f += 0.3) {
    // Rotations are met exactly; chords of the curved path cut its corners by a millimetre or two.
    EXPECT_THAT(spline.At(1.0 + 0.1 * f), Rigid3dNear(Rigid3d::Exp(f * Step()), 1e-9, 0.01));
  }
}

TEST(PoseSplineTest, IsSmooth) {
  Rng rng(3);
  std::vector<Rigid3d> control = ConstantMotion(20);
  for (Rigid3d& T : control) {
    Vector6d noise;
    for (int i = 0; i < 6; ++i) noise[i] = 0.05 * rng.Normal();
    T = T * Rigid3d::Exp(noise);
  }
  const PoseSpline spline(control, 0.0, 1.0);
  // Velocities on both sides of a knot agree: no jump.
  constexpr double kStep = 1e-4;
  for (int knot = 2; knot < 17; ++knot) {
    const Rigid3d before = spline.At(knot - kStep), at = spline.At(knot);
    const Rigid3d after = spline.At(knot + kStep);
    const Vector6d left = (before.Inverse() * at).Log() / kStep;
    const Vector6d right = (at.Inverse() * after).Log() / kStep;
    EXPECT_LT((left - right).norm(), 1e-3) << "knot " << knot;
  }
}

TEST(PoseSplineTest, NeedsFourPoses) {
  EXPECT_THROW(PoseSpline(ConstantMotion(3), 0.0, 0.1), Error);
}

TEST(SmoothPosesTest, RemovesJitterAndKeepsEnds) {
  Rng rng(4);
  std::vector<Rigid3d> truth;  // straight: averaging cuts the corners of a bend
  for (int i = 0; i < 60; ++i) truth.push_back(Rigid3d::Translation(i, 0, 0));
  std::vector<Rigid3d> noisy;
  for (const Rigid3d& T : truth) {
    noisy.push_back(T * Rigid3d::Translation(0.02 * rng.Normal(), 0.02 * rng.Normal(), 0));
  }
  const std::vector<Rigid3d> smooth = SmoothPoses(noisy, 1.5);
  double before = 0.0, after = 0.0;
  for (size_t i = 10; i < 50; ++i) {
    before += (noisy[i].t() - truth[i].t()).squaredNorm();
    after += (smooth[i].t() - truth[i].t()).squaredNorm();
  }
  EXPECT_LT(after, 0.4 * before);
  EXPECT_THAT(smooth.front(), Rigid3dNear(noisy.front(), 1e-9, 1e-9));
  EXPECT_THAT(smooth.back(), Rigid3dNear(noisy.back(), 1e-9, 1e-9));
}

TEST(ExtendPosesTest, GoesOnAtTheVelocityOfTheEnds) {
  const std::vector<Rigid3d> poses = ExtendPoses(ConstantMotion(5), 3);
  ASSERT_EQ(poses.size(), 11U);
  for (int i = 0; i < 11; ++i) {
    EXPECT_THAT(poses[static_cast<size_t>(i)],
                Rigid3dNear(Rigid3d::Exp((i - 3.0) * Step()), 1e-9, 1e-9));
  }
}

}  // namespace
}  // namespace tvl::sim
