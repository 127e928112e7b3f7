#include <gtest/gtest.h>

#include "tvl/base/rng.h"
#include "tvl/factors/epipolar.h"
#include "tvl/factors/point_to_line.h"
#include "tvl/factors/point_to_plane.h"
#include "tvl/factors/pose_prior.h"
#include "tvl/factors/reprojection.h"
#include "tvl/optim/numeric_jacobian.h"

namespace tvl {
namespace {

Eigen::Vector3d RandomVector(Rng& rng, double scale) {
  return scale * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
}

Rigid3d RandomMotion(Rng& rng) {
  Vector6d xi;
  xi << RandomVector(rng, 0.3), RandomVector(rng, 2.0);
  return Rigid3d::Exp(xi);
}

// x right, y down, z forward, a little ahead of the lidar.
Rigid3d CameraMount() {
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return Rigid3d(R, Eigen::Vector3d(0.0, -0.08, -0.27)) *
         Rigid3d::Exp((Vector6d() << 0.02, -0.01, 0.03, 0, 0, 0).finished());
}

class Factors : public ::testing::TestWithParam<uint64_t> {
 protected:
  Factors() : rng_(GetParam()), T_(RandomMotion(rng_)) {}
  Rng rng_;
  Rigid3d T_;
};

TEST_P(Factors, PointToPlane) {
  const PointToPlane f{RandomVector(rng_, 10.0), RandomVector(rng_, 1.0).normalized(),
                       RandomVector(rng_, 10.0)};
  const auto r = [&](const Rigid3d& T) { return Evaluate(f, T.R(), T.t()).r; };
  EXPECT_LT((Evaluate(f, T_.R(), T_.t()).J - NumericJacobian(r, T_)).norm(), 1e-6);
  EXPECT_NEAR(r(T_)[0], f.n_ref.dot(T_ * f.p_body - f.q_ref), 1e-12);
}

TEST_P(Factors, PointToLine) {
  const PointToLine f{RandomVector(rng_, 10.0), RandomVector(rng_, 1.0).normalized(),
                      RandomVector(rng_, 10.0)};
  const auto r = [&](const Rigid3d& T) { return Evaluate(f, T.R(), T.t()).r; };
  EXPECT_LT((Evaluate(f, T_.R(), T_.t()).J - NumericJacobian(r, T_)).norm(), 1e-6);
  const Eigen::Vector3d off = T_ * f.p_body - f.q_ref;
  EXPECT_NEAR(r(T_).norm(), off.cross(f.d_ref).norm(), 1e-9);
}

TEST_P(Factors, Reprojection) {
  const Rigid3d T_cam_body = CameraMount();
  const Eigen::Vector3d p_body(8.0 + 10.0 * rng_.Uniform(), 3.0 * rng_.Normal(), rng_.Normal());
  const Reprojection f{T_ * p_body + RandomVector(rng_, 0.1), {0.1, -0.2}};
  const auto r = [&](const Rigid3d& T) { return Evaluate(f, T, T_cam_body).r; };
  EXPECT_LT((Evaluate(f, T_, T_cam_body).J - NumericJacobian(r, T_)).norm(), 1e-6);
}

TEST_P(Factors, InverseReprojection) {
  const Rigid3d T_cam_body = CameraMount();
  const Eigen::Vector3d p_ref(8.0 + 10.0 * rng_.Uniform(), 3.0 * rng_.Normal(), rng_.Normal());
  const InverseReprojection f{T_.Inverse() * p_ref, {0.1, -0.2}};
  const auto r = [&](const Rigid3d& T) { return Evaluate(f, T, T_cam_body).r; };
  EXPECT_LT((Evaluate(f, T_, T_cam_body).J - NumericJacobian(r, T_)).norm(), 1e-6);
}

TEST_P(Factors, ReprojectionsOfOnePointVanishAtTheTruth) {
  const Rigid3d T_cam_body = CameraMount();
  const Eigen::Vector3d p_body(12.0, 2.0, -1.0), p_ref = T_ * p_body;
  const auto ray = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d c = T_cam_body * p;
    return Eigen::Vector2d(c.head<2>() / c.z());
  };
  EXPECT_LT(Evaluate(Reprojection{p_ref, ray(p_body)}, T_, T_cam_body).r.norm(), 1e-12);
  EXPECT_LT(Evaluate(InverseReprojection{p_body, ray(p_ref)}, T_, T_cam_body).r.norm(), 1e-12);
  const Epipolar e{(T_cam_body * p_body).normalized(), (T_cam_body * p_ref).normalized()};
  EXPECT_NEAR(Evaluate(e, T_, T_cam_body, T_cam_body.Adjoint()).r[0], 0.0, 1e-12);
}

TEST_P(Factors, Epipolar) {
  const Rigid3d T_cam_body = CameraMount();
  const Epipolar f{RandomVector(rng_, 1.0).normalized(), RandomVector(rng_, 1.0).normalized()};
  const auto r = [&](const Rigid3d& T) {
    return Evaluate(f, T, T_cam_body, T_cam_body.Adjoint()).r;
  };
  EXPECT_LT((Evaluate(f, T_, T_cam_body, T_cam_body.Adjoint()).J - NumericJacobian(r, T_)).norm(),
            1e-5);
}

// Noise in both rays must not draw the baseline towards where there is more to see: at the truth
// the gradient of the squares has mean zero.
TEST(EpipolarNoise, DoesNotDrawTheBaselineTowardsTheCrowdedSide) {
  Rng rng(11);
  const Rigid3d T_cam_body = CameraMount();
  const Rigid3d T_ref_body = Rigid3d::Translation(5.0, 0.0, 0.0);
  const Matrix6d adjoint = T_cam_body.Adjoint();
  constexpr double kNoise_rad = 2e-3;
  constexpr int kTrials = 200000;
  Vector6d sum = Vector6d::Zero(), sum_sq = Vector6d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    // All things stand to the right.
    const Eigen::Vector3d p_ref(30.0, -3.0 - 2.0 * rng.Uniform(0.0, 1.0), rng.Uniform(-1.0, 1.0));
    const Eigen::Vector3d a = (T_cam_body * (T_ref_body.Inverse() * p_ref)).normalized();
    const Eigen::Vector3d b = (T_cam_body * p_ref).normalized();
    const Epipolar f{(a + RandomVector(rng, kNoise_rad)).normalized(),
                     (b + RandomVector(rng, kNoise_rad)).normalized()};
    const Residual<1> residual = Evaluate(f, T_ref_body, T_cam_body, adjoint);
    const Vector6d gradient = residual.J.transpose() * residual.r;
    sum += gradient;
    sum_sq += gradient.cwiseAbs2();
  }
  for (int axis = 0; axis < 6; ++axis) {
    const double sigma = std::sqrt(sum_sq[axis] / kTrials / kTrials);
    EXPECT_LT(std::abs(sum[axis] / kTrials), 4.0 * sigma + 1e-9) << "axis " << axis;
  }
}

TEST_P(Factors, PosePrior) {
  const Rigid3d T_prior = RandomMotion(rng_);
  const auto r = [&](const Rigid3d& T) { return EvaluatePosePrior(T_prior, T).r; };
  EXPECT_LT((EvaluatePosePrior(T_prior, T_).J - NumericJacobian(r, T_)).norm(), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Factors, ::testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace tvl
