#include "tvl/slam/pose_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Directions that nothing holds get this standard deviation (rad, m) at the most.
constexpr double kUnknownSigma = 10.0;
// Of what is known exactly, so that it has an inverse (rad, m).
constexpr double kExactSigma = 1e-6;

Matrix6d Symmetric(const Matrix6d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

Matrix6d Inverse(const Matrix6d& matrix) { return matrix.ldlt().solve(Matrix6d::Identity()); }

Matrix6d Carried(const Matrix6d& covariance, const Matrix6d& adjoint) {
  return adjoint * covariance * adjoint.transpose();
}

}  // namespace

void PoseUncertaintyOptions::Check() const {
  TVL_CHECK_INPUT(noise_share > 0.0)
      << "uncertainty.noise_share: must be positive, is " << noise_share;
  TVL_CHECK_INPUT(walk_per_m >= 0.0 && bias_level_rad_per_m >= 0.0 && bias_yaw_rad_per_m >= 0.0 &&
                  bias_scale >= 0.0)
      << "uncertainty.walk_per_m, bias_*: must not be negative";
  TVL_CHECK_INPUT(independent_path_m >= 0.0)
      << "uncertainty.independent_path_m: must not be negative, is " << independent_path_m;
}

MapError::MapError(const PoseUncertaintyOptions& options) : options_(options) {}

MapError::Change MapError::Add(const PoseStep& step) {
  Change change;
  change.T_prev_cur = step.T_prev_cur;
  change.length_m = step.T_prev_cur.t().norm();
  const Matrix6d adjoint = step.T_prev_cur.Inverse().Adjoint();
  const Matrix6d exact = Matrix6d::Identity() * (kExactSigma * kExactSigma);
  const Matrix6d unknown = Matrix6d::Identity() / (kUnknownSigma * kUnknownSigma);
  const Matrix6d predicted =
      Inverse(Inverse(Carried(covariance_, adjoint) + step.motion_covariance + exact) + unknown);
  const Matrix6d of_prediction = Inverse(predicted);
  covariance_ = Symmetric(Inverse(of_prediction + step.map_information / options_.noise_share));
  change.covariance = covariance_;
  change.persistence = covariance_ * of_prediction * adjoint;
  // What the map passes on is what it was built with: no more than the motion alone leaves open.
  const Matrix6d claimed =
      Inverse(step.map_information + Inverse(step.motion_covariance + exact) + unknown);
  change.walk = Symmetric(options_.walk_per_m * change.length_m * claimed + step.beyond_covariance);
  return change;
}

RelativeUncertainty::RelativeUncertainty(const PoseUncertaintyOptions& options,
                                         const Matrix6d& start_covariance)
    : options_(options),
      start_(start_covariance),
      now_(start_covariance),
      cross_(start_covariance) {}

void RelativeUncertainty::Add(const MapError::Change& change) {
  const Matrix6d adjoint = change.T_prev_cur.Inverse().Adjoint();
  T_start_now_ = T_start_now_ * change.T_prev_cur;
  path_m_ += change.length_m;
  now_ = change.covariance;
  cross_ = (change.persistence * cross_).eval();
  walk_ = Symmetric(Carried(walk_, adjoint) + change.walk);
  bias_effect_ = (adjoint * bias_effect_).eval();
  bias_effect_.topLeftCorner<3, 3>().diagonal().array() += change.length_m;
  bias_effect_.bottomRightCorner<3, 1>() +=
      change.T_prev_cur.R().transpose() * change.T_prev_cur.t();
}

void RelativeUncertainty::BeginMap() {
  walk_ += now_;
  now_.setZero();
  cross_.setZero();
}

Matrix6d RelativeUncertainty::CovarianceOfIndependentStep() const {
  // n steps of length l with the same error b l add up to (n b l)^2, independent ones to n (b l)^2
  // times the factor.
  return CovarianceWith(path_m_ > 0.0 ? std::max(1.0, options_.independent_path_m / path_m_) : 1.0);
}

Matrix6d RelativeUncertainty::CovarianceWith(double bias_factor) const {
  const Eigen::Vector4d bias(options_.bias_level_rad_per_m, options_.bias_level_rad_per_m,
                             options_.bias_yaw_rad_per_m, options_.bias_scale);
  const Eigen::Matrix<double, 6, 4> of_bias = bias_effect_ * bias.asDiagonal();
  const Matrix6d adjoint = T_start_now_.Inverse().Adjoint();
  const Matrix6d cross = cross_ * adjoint.transpose();
  return Symmetric(now_ + Carried(start_, adjoint) - cross - cross.transpose() + walk_ +
                   bias_factor * of_bias * of_bias.transpose());
}

OdometryUncertainty::OdometryUncertainty(const PoseUncertaintyOptions& options)
    : options_(options),
      map_error_(options),
      since_first_(options, Matrix6d::Zero()),
      since_keyframe_(options, Matrix6d::Zero()) {}

Matrix6d OdometryUncertainty::Add(const PoseStep& step) {
  RelativeUncertainty since_previous(options_, map_error_.covariance());
  const MapError::Change change = map_error_.Add(step);
  walk_ = change.walk;
  for (RelativeUncertainty* since : {&since_previous, &since_first_, &since_keyframe_}) {
    since->Add(change);
  }
  return since_previous.Covariance();
}

void OdometryUncertainty::BeginMap() {
  map_error_.BeginMap();
  since_first_.BeginMap();
  since_keyframe_.BeginMap();
}

void OdometryUncertainty::BeginKeyframe() {
  since_keyframe_ = RelativeUncertainty(options_, map_error_.covariance());
}

}  // namespace tvl
