#include "tvl/registration/beam_calibration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/geometry/robust.h"
#include "tvl/registration/beam_directions.h"

namespace tvl {
void BeamCalibrationOptions::Check() const {
  TVL_CHECK_INPUT(prior_elevation_rad > 0.0)
      << "beam_calibration.prior_elevation_rad: must be positive";
  TVL_CHECK_INPUT(prior_range_m > 0.0) << "beam_calibration.prior_range_m: must be positive";
  TVL_CHECK_INPUT(information_share > 0.0 && information_share <= 1.0)
      << "beam_calibration.information_share: must be in (0, 1]";
  TVL_CHECK_INPUT(memory_frames >= 1.0) << "beam_calibration.memory_frames: must be at least 1";
  TVL_CHECK_INPUT(update_every >= 1) << "beam_calibration.update_every: must be at least 1";
}

BeamCalibration::BeamCalibration(int rings, const BeamCalibrationOptions& options)
    : rings_(rings),
      options_(options),
      A_(Eigen::MatrixXd::Zero(2 * rings, 2 * rings)),
      c_(Eigen::VectorXd::Zero(2 * rings)),
      current_(Eigen::VectorXd::Zero(2 * rings)) {
  options_.Check();
}

BeamCalibration::Sums BeamCalibration::SumUp(const std::vector<PlaneMatch>& matches,
                                             const std::vector<uint16_t>& rings,
                                             const Rigid3d& T_world_lidar,
                                             double kernel_sigmas) const {
  const Eigen::Matrix3d R = T_world_lidar.R();
  Sums sums;
  sums.H_cross = Eigen::MatrixXd::Zero(6, 2 * rings_);
  sums.A = Eigen::MatrixXd::Zero(2 * rings_, 2 * rings_);
  sums.b = Eigen::VectorXd::Zero(2 * rings_);
  for (size_t i = 0; i < matches.size(); ++i) {
    const Residual<1> residual = Evaluate(matches[i].factor, R, T_world_lidar.t());
    const double whitened_sq = residual.r.squaredNorm() * matches[i].information;
    const double weight = options_.information_share * matches[i].information *
                          Cauchy(whitened_sq, kernel_sigmas).weight;
    const Eigen::Vector3d n_body = R.transpose() * matches[i].factor.n_ref;
    const BeamDirections along = DirectionsAt(matches[i].factor.p_body);
    const Eigen::Vector2d J(n_body.dot(along.elevation), n_body.dot(along.range));
    const int at = 2 * rings[i];
    sums.H_pose += weight * residual.J.transpose() * residual.J;
    sums.b_pose += weight * residual.J.transpose() * residual.r;
    sums.H_cross.middleCols<2>(at) += weight * residual.J.transpose() * J.transpose();
    sums.A.block<2, 2>(at, at) += weight * J * J.transpose();
    sums.b.segment<2>(at) += weight * J * residual.r[0];
  }
  return sums;
}

void BeamCalibration::Add(const std::vector<PlaneMatch>& matches,
                          const std::vector<uint16_t>& rings, const Rigid3d& T_world_lidar,
                          double kernel_sigmas) {
  TVL_CHECK(matches.size() == rings.size()) << "a ring for each match";
  if (!options_.enabled || rings_ == 0 || matches.empty()) return;
  Sums sums = SumUp(matches, rings, T_world_lidar, kernel_sigmas);
  // The frame's pose is marginalised out: what the pose can explain is no evidence of a beam.
  const Eigen::MatrixXd gain = sums.H_pose.ldlt().solve(sums.H_cross);
  sums.A -= sums.H_cross.transpose() * gain;
  sums.b -= gain.transpose() * sums.b_pose;
  const double keep = std::exp(-1.0 / options_.memory_frames);
  A_ = keep * A_ + sums.A;
  c_ = keep * c_ + sums.b - sums.A * current_;
  if (++frames_ % options_.update_every == 0) Solve();
}

void BeamCalibration::Solve() {
  Eigen::MatrixXd A = A_;
  for (int ring = 0; ring < rings_; ++ring) {
    A(2 * ring, 2 * ring) += std::pow(options_.prior_elevation_rad, -2);
    A(2 * ring + 1, 2 * ring + 1) += std::pow(options_.prior_range_m, -2);
  }
  current_ = -A.ldlt().solve(c_);
  const Eigen::Map<Eigen::Matrix2Xd> offsets(current_.data(), 2, rings_);
  const Eigen::Vector2d mean = offsets.rowwise().mean();
  offsets_ = {};
  for (int ring = 0; ring < rings_; ++ring) {
    current_.segment<2>(2 * ring) -= mean;
    offsets_.elevation_rad.push_back(static_cast<float>(current_[2 * ring]));
    offsets_.range_m.push_back(static_cast<float>(current_[2 * ring + 1]));
  }
}

void ApplyBeamOffsets(const BeamOffsets& offsets, const std::vector<uint16_t>& ring,
                      std::vector<Eigen::Vector3f>* points) {
  if (offsets.elevation_rad.empty()) return;
  for (size_t i = 0; i < points->size(); ++i) {
    Eigen::Vector3f& p = (*points)[i];
    const float horizontal = std::max(1e-6f, p.head<2>().norm());
    const float lift = -p.z() / horizontal;
    const Eigen::Vector3f up(lift * p.x(), lift * p.y(), horizontal);
    p += offsets.elevation_rad[ring[i]] * up + (offsets.range_m[ring[i]] / p.norm()) * p;
  }
}

}  // namespace tvl
