#include "tvl/slam/motion_model.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

Rigid3d Curve() {
  Vector6d xi;
  xi << 0.0, 0.01, 0.05, 1.2, 0.1, -0.02;
  return Rigid3d::Exp(xi);
}

double SigmaX_m(const MotionPrediction& prediction) {
  return std::sqrt(prediction.covariance(3, 3));
}

TEST(MotionModel, KnowsNothingAtFirst) {
  const MotionModel model{MotionModelOptions()};
  const MotionPrediction prediction = model.Predict(1, 0.1);
  EXPECT_FALSE(prediction.known);
  EXPECT_THAT(prediction.T_prev_cur, Rigid3dNear(Rigid3d(), 1e-12, 1e-12));
  EXPECT_GT(SigmaX_m(prediction), 3.0);
}

TEST(MotionModel, CarriesTheVelocityOnOverAnyNumberOfPeriods) {
  MotionModel model{MotionModelOptions()};
  model.Update(Curve() * Curve(), Matrix6d::Zero(), 2);
  EXPECT_THAT(model.Predict(1, 0.1).T_prev_cur, Rigid3dNear(Curve(), 1e-9, 1e-9));
  EXPECT_THAT(model.Predict(3, 0.1).T_prev_cur,
              Rigid3dNear(Curve() * Curve() * Curve(), 1e-9, 1e-9));
  EXPECT_THAT(model.Predict(0, 0.1).T_prev_cur, Rigid3dNear(Rigid3d(), 1e-12, 1e-12));
}

// Velocities that change by independent steps: the spread of the displacement is what the model
// says of it.
TEST(MotionModel, CovarianceIsThatOfAWanderingVelocity) {
  const MotionModelOptions options;
  Rng rng(4);
  for (const int periods : {1, 3, 8}) {
    MotionModel model(options);
    model.Update(Rigid3d::Translation(1.0, 0.0, 0.0), Matrix6d::Zero(), 1);
    double sum_sq = 0.0;
    constexpr int kTrials = 4000;
    for (int trial = 0; trial < kTrials; ++trial) {
      double velocity_m = 0.0, off_m = 0.0;
      for (int k = 0; k < periods; ++k) {
        velocity_m += options.acceleration_sigma_m * rng.Normal();
        off_m += velocity_m;
      }
      sum_sq += off_m * off_m;
    }
    EXPECT_NEAR(SigmaX_m(model.Predict(periods, 0.1)) / std::sqrt(sum_sq / kTrials), 1.0, 0.05)
        << periods;
  }
}

TEST(MotionModel, UncertaintyGrowsWhileNothingIsMeasuredAndShrinksAfterwards) {
  MotionModel model{MotionModelOptions()};
  model.Update(Curve(), 1e-6 * Matrix6d::Identity(), 1);
  double before_m = SigmaX_m(model.Predict(1, 0.1));
  for (int k = 0; k < 5; ++k) {
    model.Coast(1);
    EXPECT_GT(SigmaX_m(model.Predict(1, 0.1)), before_m);
    before_m = SigmaX_m(model.Predict(1, 0.1));
  }
  EXPECT_THAT(model.Predict(1, 0.1).T_prev_cur, Rigid3dNear(Curve(), 1e-9, 1e-9));
  model.Update(Curve(), 1e-6 * Matrix6d::Identity(), 1);
  EXPECT_LT(SigmaX_m(model.Predict(1, 0.1)), before_m);
}

TEST(MotionModel, ForgetsOnDemand) {
  MotionModel model{MotionModelOptions()};
  model.Update(Curve(), Matrix6d::Zero(), 1);
  model.Forget();
  EXPECT_FALSE(model.known());
  EXPECT_FALSE(model.Predict(1, 0.1).known);
}

TEST(MotionModelOptions, NameTheBadField) {
  MotionModelOptions options;
  options.acceleration_sigma_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
