#include "tvl/slam/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <vector>

namespace tvl {
namespace {

// What a scan claims in a street: 0.2 mrad and 4 mm.
Matrix6d StreetInformation() {
  Vector6d sigma;
  sigma << 2e-4, 1.5e-4, 2e-4, 4e-3, 3e-3, 2e-3;
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

// What scan-to-scan odometry claims.
Matrix6d MotionCovariance() {
  Vector6d sigma;
  sigma << 1e-3, 1e-3, 1e-3, 0.03, 0.02, 0.02;
  return sigma.cwiseAbs2().asDiagonal();
}

PoseStep StreetStep(double forward_m) {
  PoseStep step;
  step.T_prev_cur = Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(forward_m, 0.0, 0.0));
  step.motion_covariance = MotionCovariance();
  step.map_information = StreetInformation();
  return step;
}

// After `steps` equal ones.
Matrix6d After(int steps, const PoseStep& step,
               const PoseUncertaintyOptions& options = PoseUncertaintyOptions()) {
  OdometryUncertainty uncertainty(options);
  for (int i = 0; i < steps; ++i) uncertainty.Add(step);
  return uncertainty.SinceFirst();
}

double Sigma(const Matrix6d& covariance, int axis) { return std::sqrt(covariance(axis, axis)); }

TEST(PoseUncertainty, StandingAddsNothing) {
  const Matrix6d brief = After(2, StreetStep(0.0)), minute = After(600, StreetStep(0.0));
  EXPECT_TRUE(minute.isApprox(brief, 1e-2)) << minute << "\n\n" << brief;
  EXPECT_NEAR(Sigma(minute, 3), std::sqrt(0.25) * 4e-3, 1e-4) << "a quarter of what is claimed";
}

TEST(PoseUncertainty, DoesNotDependOnTheFrameRate) {
  for (const double path_m : {1.0, 10.0, 100.0, 400.0}) {
    const Matrix6d slow = After(static_cast<int>(path_m), StreetStep(1.0));
    const Matrix6d fast = After(static_cast<int>(4.0 * path_m), StreetStep(0.25));
    for (int axis = 0; axis < 6; ++axis) {
      EXPECT_NEAR(Sigma(fast, axis) / Sigma(slow, axis), 1.0, 0.05) << path_m << " m, " << axis;
    }
  }
}

TEST(PoseUncertainty, ABiasOfThePitchLiftsWithTheSquareOfThePath) {
  PoseUncertaintyOptions options;
  options.walk_per_m = 0.0;
  options.bias_scale = 0.0;
  const Matrix6d covariance = After(400, StreetStep(1.0), options);
  EXPECT_NEAR(Sigma(covariance, 1), 400.0 * options.bias_level_rad_per_m, 2e-4);
  EXPECT_NEAR(Sigma(covariance, 5), 0.5 * 400.0 * 400.0 * options.bias_level_rad_per_m, 0.02);
  EXPECT_NEAR(Sigma(covariance, 4), 0.5 * 400.0 * 400.0 * options.bias_yaw_rad_per_m, 0.01);
}

TEST(PoseUncertainty, WhatNothingHoldsGrowsFromFrameToFrame) {
  PoseStep tunnel = StreetStep(1.0);
  tunnel.map_information.row(3).setZero();
  tunnel.map_information.col(3).setZero();
  const Matrix6d short_way = After(10, tunnel), long_way = After(40, tunnel);
  EXPECT_NEAR(Sigma(long_way, 3) / Sigma(short_way, 3), 2.0, 0.1) << "as the odometry's steps do";
  EXPECT_NEAR(Sigma(long_way, 3), std::sqrt(40.0) * 0.03, 0.02);
  EXPECT_LT(Sigma(long_way, 4), 0.02) << "the walls still hold the way across";
}

TEST(PoseUncertainty, ALostStretchIsForgottenWhereTheMapIsFoundAgain) {
  const PoseUncertaintyOptions options;
  OdometryUncertainty uncertainty(options);
  for (int i = 0; i < 10; ++i) uncertainty.Add(StreetStep(1.0));
  const double before = Sigma(uncertainty.SinceFirst(), 3);
  PoseStep dark = StreetStep(1.0);
  dark.map_information.setZero();
  dark.motion_covariance.diagonal().tail<3>().setConstant(1.0);
  for (int i = 0; i < 3; ++i) uncertainty.Add(dark);
  EXPECT_GT(Sigma(uncertainty.SinceFirst(), 3), 1.5);
  const Matrix6d step = uncertainty.Add(StreetStep(1.0));
  EXPECT_GT(Sigma(step, 3), 1.5) << "the step from a pose that was not known";
  EXPECT_LT(Sigma(uncertainty.SinceFirst(), 3), 1.0) << before;
}

TEST(PoseUncertainty, ANewMapKeepsWhatWasNotKnown) {
  OdometryUncertainty uncertainty((PoseUncertaintyOptions()));
  PoseStep dark = StreetStep(1.0);
  dark.map_information.setZero();
  dark.motion_covariance.diagonal().tail<3>().setConstant(1.0);
  for (int i = 0; i < 4; ++i) uncertainty.Add(dark);
  uncertainty.BeginMap();
  for (int i = 0; i < 10; ++i) uncertainty.Add(StreetStep(1.0));
  EXPECT_GT(Sigma(uncertainty.SinceFirst(), 3), 1.9);
}

// Errors drawn as the model says, in a bend, add up to the covariance that it says.
TEST(PoseUncertainty, AgreesWithErrorsDrawnAtRandom) {
  PoseUncertaintyOptions options;
  options.bias_scale = 2e-3;
  const Rigid3d T_prev_cur = Rigid3d::Exp((Vector6d() << 0.0, 0.0, 0.02, 1.0, 0.0, 0.0).finished());
  PoseStep step = StreetStep(1.0);
  step.T_prev_cur = T_prev_cur;
  constexpr int kSteps = 60, kTrials = 4000;
  // Covariances of what every step draws.
  MapError map_error(options);
  std::vector<MapError::Change> changes;
  RelativeUncertainty since(options, map_error.covariance());
  for (int i = 0; i < kSteps; ++i) {
    changes.push_back(map_error.Add(step));
    since.Add(changes.back());
  }
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](const Matrix6d& covariance) {
    const Vector6d white = Vector6d::NullaryExpr([&] { return normal(random); });
    return Vector6d(covariance.llt().matrixL() * white);
  };
  const Eigen::Vector3d way_m = T_prev_cur.R().transpose() * T_prev_cur.t();
  double chi2 = 0.0;
  const Matrix6d information = since.Covariance().inverse();
  for (int trial = 0; trial < kTrials; ++trial) {
    Vector6d bias;  // of a step
    bias << changes[0].length_m * options.bias_level_rad_per_m * normal(random),
        changes[0].length_m * options.bias_level_rad_per_m * normal(random),
        changes[0].length_m * options.bias_yaw_rad_per_m * normal(random),
        options.bias_scale * normal(random) * way_m;
    Rigid3d T_map_true, T_map_found;  // the map's own drift is part of where it says that it is
    Vector6d noise = Vector6d::Zero();
    for (const MapError::Change& change : changes) {
      T_map_true = T_map_true * T_prev_cur;
      T_map_found = T_map_found * T_prev_cur * Rigid3d::Exp(draw(change.walk) + bias);
      noise = draw(change.covariance);
    }
    const Vector6d error = (T_map_true.Inverse() * T_map_found * Rigid3d::Exp(noise)).Log();
    chi2 += error.dot(information * error) / 6.0;
  }
  EXPECT_NEAR(chi2 / kTrials, 1.0, 0.05);
}

TEST(PoseUncertainty, StepsOfAGraphAddUpOverTheIndependentPath) {
  PoseUncertaintyOptions options;
  options.walk_per_m = 0.0;
  RelativeUncertainty step(options, Matrix6d::Zero()), whole(options, Matrix6d::Zero());
  MapError map_error(options);
  const MapError::Change change = map_error.Add(StreetStep(1.0));
  step.Add(change);
  for (int i = 0; i < 100; ++i) whole.Add(change);
  const Matrix6d noise = change.covariance;
  EXPECT_NEAR(100.0 * (step.CovarianceOfIndependentStep() - noise)(1, 1),
              (whole.Covariance() - noise)(1, 1), 1e-9);
}

}  // namespace
}  // namespace tvl
