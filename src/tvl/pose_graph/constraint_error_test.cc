#include "tvl/pose_graph/constraint_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/optim/numeric_jacobian.h"

namespace tvl {
namespace {

Rigid3d RandomPose(Rng* rng, double rotation_rad, double translation_m) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? rotation_rad : translation_m) * rng->Normal();
  return Rigid3d::Exp(xi);
}

TEST(ConstraintError, VanishesForThePosesThatWereMeasured) {
  Rng rng(1);
  const Rigid3d T_from = RandomPose(&rng, 1.0, 100.0), T_to = RandomPose(&rng, 1.0, 100.0);
  const PoseConstraint c{0, 1, T_from.Inverse() * T_to, Matrix6d::Identity()};
  EXPECT_LT(ConstraintError(c, T_from, T_to).norm(), 1e-9);
  // A motion of the second pose ahead by 0.1 m in its own frame is an error of just that.
  Vector6d ahead = Vector6d::Zero();
  ahead[3] = 0.1;
  EXPECT_LT((ConstraintError(c, T_from, T_to * Rigid3d::Exp(ahead)) - ahead).norm(), 1e-9);
}

TEST(ConstraintError, JacobiansAgreeWithNumericOnes) {
  Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Rigid3d T_from = RandomPose(&rng, 1.0, 10.0);
    const Rigid3d T_to = T_from * RandomPose(&rng, 0.5, 3.0);
    const PoseConstraint c{0, 1, RandomPose(&rng, 0.5, 3.0), Matrix6d::Identity()};
    const ConstraintJacobians lin = LinearizeConstraint(c, T_from, T_to);
    const auto by_from =
        NumericJacobian([&](const Rigid3d& T) { return ConstraintError(c, T, T_to); }, T_from);
    const auto by_to =
        NumericJacobian([&](const Rigid3d& T) { return ConstraintError(c, T_from, T); }, T_to);
    EXPECT_LT((lin.J_from - by_from).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((lin.J_to - by_to).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(ConstraintError, BlocksAreTheGradientOfTheCost) {
  Rng rng(3);
  const Rigid3d T_from = RandomPose(&rng, 1.0, 10.0), T_to = RandomPose(&rng, 1.0, 10.0);
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = rng.Normal();
  const PoseConstraint c{0, 1, RandomPose(&rng, 0.3, 3.0), A * A.transpose()};
  const ConstraintBlocks blocks = NormalBlocks(c, 0.5, T_from, T_to);
  using Scalar = Eigen::Matrix<double, 1, 1>;
  const auto by_from = NumericJacobian(
      [&](const Rigid3d& T) { return Scalar(0.25 * SquaredError(c, T, T_to)); }, T_from);
  const auto by_to = NumericJacobian(
      [&](const Rigid3d& T) { return Scalar(0.25 * SquaredError(c, T_from, T)); }, T_to);
  EXPECT_LT((blocks.b_f.transpose() - by_from).norm(), 1e-5 * blocks.b_f.norm());
  EXPECT_LT((blocks.b_t.transpose() - by_to).norm(), 1e-5 * blocks.b_t.norm());
  const ConstraintJacobians lin = LinearizeConstraint(c, T_from, T_to);
  const Matrix6d H_ft = 0.5 * lin.J_from.transpose() * c.information * lin.J_to;
  EXPECT_LT((blocks.H_ft - H_ft).norm(), 1e-9 * H_ft.norm());
}

std::string ErrorOf(const PoseConstraint& c) {
  try {
    CheckConstraint(c, 3, "loop");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(ConstraintError, BadConstraintsAreNamed) {
  EXPECT_EQ(ErrorOf({0, 2, Rigid3d(), Matrix6d::Identity()}), "no error");
  EXPECT_THAT(ErrorOf({0, 3, Rigid3d(), Matrix6d::Identity()}), testing::HasSubstr("to pose 3"));
  EXPECT_THAT(ErrorOf({1, 1, Rigid3d(), Matrix6d::Identity()}), testing::HasSubstr("from pose 1"));
  EXPECT_THAT(ErrorOf({0, 1, Rigid3d(), -Matrix6d::Identity()}),
              testing::HasSubstr("positive definite"));
  Matrix6d lopsided = Matrix6d::Identity();
  lopsided(0, 1) = 0.5;
  EXPECT_THAT(ErrorOf({0, 1, Rigid3d(), lopsided}), testing::HasSubstr("symmetric"));
  EXPECT_THAT(ErrorOf({0, 1, Rigid3d::Translation(NAN, 0, 0), Matrix6d::Identity()}),
              testing::HasSubstr("not finite"));
}

}  // namespace
}  // namespace tvl
