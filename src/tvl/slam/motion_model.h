// What motion is expected next: constant velocity, with a covariance that grows with the time
// bridged and shrinks with what is measured. A value: copies are independent.
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

struct MotionModelOptions {
  // Change of velocity a vehicle manages within one period (5 m/s^2, 1 rad/s^2 over 0.1 s, as
  // displacement): what constant velocity is wrong by, one standard deviation.
  double acceleration_sigma_m = 0.05, acceleration_sigma_rad = 0.01;
  void Check() const;
};

struct MotionPrediction {
  Rigid3d T_prev_cur;
  // Right perturbation in the current body frame, [rotation, translation].
  Matrix6d covariance = Matrix6d::Identity();
  int periods = 1;        // of the lidar, between the two frames
  double period_s = 0.1;  // one of them
  bool known = false;     // false: no velocity is known, the motion is the identity

  double duration_s() const { return periods * period_s; }
};

class MotionModel {
 public:
  explicit MotionModel(const MotionModelOptions& options);

  bool known() const { return known_; }
  // Motion in one period; identity if not known.
  const Rigid3d& T_period() const { return T_period_; }

  // The motion of the next `periods` (0: none, the vehicle has not moved).
  MotionPrediction Predict(int periods, double period_s) const;

  // The motion over `periods` was found with this covariance (as MotionPrediction's).
  void Update(const Rigid3d& T_prev_cur, const Matrix6d& covariance, int periods);
  // Nothing was measured for `periods`: the velocity stays and its covariance grows.
  void Coast(int periods);
  // The velocity is no longer known.
  void Forget();

 private:
  Matrix6d AccelerationCovariance(int periods) const;

  MotionModelOptions options_;
  bool known_ = false;
  Rigid3d T_period_;
  Matrix6d covariance_ = Matrix6d::Zero();  // of T_period_
};

}  // namespace tvl
