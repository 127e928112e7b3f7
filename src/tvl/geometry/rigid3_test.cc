#include "tvl/geometry/rigid3.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

Vector6d RandomTangent(Rng& rng, double angle_rad, double length_m) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = rng.Normal();
  xi.head<3>() *= angle_rad / xi.head<3>().norm();
  xi.tail<3>() *= length_m / xi.tail<3>().norm();
  return xi;
}

const double kAngles_rad[] = {1e-9, 1e-5, 5e-3, 0.02, 0.5, 2.0, 3.1};

TEST(Rigid3d, ExpAndLogAreInverse) {
  Rng rng(1);
  for (const double angle : kAngles_rad) {
    const Vector6d xi = RandomTangent(rng, angle, 3.0);
    EXPECT_LT((Rigid3d::Exp(xi).Log() - xi).norm(), 1e-7) << angle;
  }
}

TEST(Rigid3d, FramesCancelAndInverseUndoes) {
  Rng rng(2);
  const Rigid3d T_a_b = Rigid3d::Exp(RandomTangent(rng, 1.0, 2.0));
  const Rigid3d T_b_c = Rigid3d::Exp(RandomTangent(rng, 0.7, 5.0));
  const Eigen::Vector3d p_c(1.0, -2.0, 3.0);
  EXPECT_LT(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm(), 1e-12);
  EXPECT_THAT(T_a_b * T_a_b.Inverse(), Rigid3dNear(Rigid3d(), 1e-12, 1e-12));
}

TEST(Rigid3d, FromMatrixRoundTrip) {
  Rng rng(3);
  const Rigid3d T = Rigid3d::Exp(RandomTangent(rng, 2.0, 2.0));
  EXPECT_THAT(Rigid3d::FromMatrix(T.Matrix()), Rigid3dNear(T, 1e-12, 1e-12));
}

TEST(Rigid3d, AdjointMovesPerturbationAcross) {
  Rng rng(4);
  const Rigid3d T = Rigid3d::Exp(RandomTangent(rng, 1.2, 2.0));
  const Vector6d xi = RandomTangent(rng, 0.3, 0.4);
  EXPECT_THAT(T * Rigid3d::Exp(xi), Rigid3dNear(Rigid3d::Exp(T.Adjoint() * xi) * T, 1e-9, 1e-9));
}

TEST(Rigid3d, RightJacobianMatchesNumeric) {
  Rng rng(5);
  const double h = 1e-6;
  for (const double angle : kAngles_rad) {
    const Vector6d xi = RandomTangent(rng, angle, 2.0);
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      Vector6d d = Vector6d::Zero();
      d[i] = h;
      numeric.col(i) = ((Rigid3d::Exp(xi).Inverse() * Rigid3d::Exp(xi + d)).Log() -
                        (Rigid3d::Exp(xi).Inverse() * Rigid3d::Exp(xi - d)).Log()) /
                       (2.0 * h);
    }
    EXPECT_LT((RightJacobianSe3(xi) - numeric).norm(), 1e-6) << angle;
    EXPECT_LT((RightJacobianSe3(xi) * RightJacobianInverseSe3(xi) - Matrix6d::Identity()).norm(),
              1e-9)
        << angle;
  }
}

TEST(Rigid3d, ScaleJacobianMatchesNumericForLargeRotations) {
  Rng rng(6);
  const double h = 1e-6;
  for (const double s : {0.5, 1.0, 1.5}) {
    const Rigid3d T = Rigid3d::Exp(RandomTangent(rng, 1.5, 3.0));
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      Vector6d d = Vector6d::Zero();
      d[i] = h;
      const Rigid3d inverse = Scale(s, T).Inverse();
      numeric.col(i) = ((inverse * Scale(s, T * Rigid3d::Exp(d))).Log() -
                        (inverse * Scale(s, T * Rigid3d::Exp(-d))).Log()) /
                       (2.0 * h);
    }
    EXPECT_LT((ScaleJacobian(s, T) - numeric).norm(), 1e-6) << s;
  }
}

}  // namespace
}  // namespace tvl
