#include "tvl/slam/motion_model.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Standard deviations of a motion of which nothing is known (rad, m): a radian, and what a fast car
// moves in a frame.
constexpr double kUnknown_rad = 1.0, kUnknown_m = 5.0;

}  // namespace

void MotionModelOptions::Check() const {
  TVL_CHECK_INPUT(acceleration_sigma_m > 0.0)
      << "motion.acceleration_sigma_m: must be positive, is " << acceleration_sigma_m;
  TVL_CHECK_INPUT(acceleration_sigma_rad > 0.0)
      << "motion.acceleration_sigma_rad: must be positive, is " << acceleration_sigma_rad;
}

MotionModel::MotionModel(const MotionModelOptions& options) : options_(options) {
  options_.Check();
}

// A velocity that changes by an independent step each period is off by the sum of the steps so far:
// over n periods the displacement's variance is that of one step times 1^2 + 2^2 + ... + n^2.
Matrix6d MotionModel::AccelerationCovariance(int periods) const {
  const double n = std::max(1, periods);
  const double sum = n * (n + 1.0) * (2.0 * n + 1.0) / 6.0;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(options_.acceleration_sigma_rad *
                                        options_.acceleration_sigma_rad),
      Eigen::Vector3d::Constant(options_.acceleration_sigma_m * options_.acceleration_sigma_m);
  return (sum * variance).asDiagonal();
}

MotionPrediction MotionModel::Predict(int periods, double period_s) const {
  MotionPrediction prediction;
  prediction.periods = std::max(1, periods);
  prediction.period_s = period_s;
  prediction.known = known_;
  if (!known_) {
    Vector6d variance;
    variance << Eigen::Vector3d::Constant(kUnknown_rad * kUnknown_rad),
        Eigen::Vector3d::Constant(kUnknown_m * kUnknown_m);
    prediction.covariance = variance.asDiagonal();
    return prediction;
  }
  prediction.T_prev_cur = Scale(periods, T_period_);
  prediction.covariance =
      covariance_ * static_cast<double>(periods * periods) + AccelerationCovariance(periods);
  return prediction;
}

void MotionModel::Update(const Rigid3d& T_prev_cur, const Matrix6d& covariance, int periods) {
  TVL_CHECK(periods >= 1) << "a motion takes time";
  T_period_ = Scale(1.0 / periods, T_prev_cur);
  covariance_ = covariance / static_cast<double>(periods * periods);
  known_ = true;
}

void MotionModel::Coast(int periods) {
  // Each period changes the velocity by an independent step.
  covariance_ += periods * AccelerationCovariance(1);
}

void MotionModel::Forget() { *this = MotionModel(options_); }

}  // namespace tvl
