#include "tvl/registration/extrinsic_calibration.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/factors/epipolar.h"
#include "tvl/geometry/robust.h"

namespace tvl {
namespace {

// Rays nearer to the direction of motion (sine of the angle) hardly tell their epipolar plane.
constexpr double kMinSine = 0.03;
constexpr double kKernelSigmas = 2.0;
// Once a correction is in use, what led to it counts for this share: it was measured with poses
// that the wrong extrinsics had pulled along, and falls short.
constexpr double kKeptAfterCorrection = 0.3;
// Edges and tracks that differ by more standard deviations do not look at the same: tracks count.
constexpr double kContradictionSigmas = 4.0;
constexpr double kSameDelaySigmas = 0.5;  // a delay that is known by so much better is not new
constexpr double kMadToSigma = 1.4826;    // of a normal distribution

std::vector<Epipolar> CommonRays(const std::vector<std::pair<TrackId, Eigen::Vector3d>>& from,
                                 const std::vector<std::pair<TrackId, Eigen::Vector3d>>& to) {
  std::vector<Epipolar> common;
  auto a = from.begin();
  for (const auto& [id, ray] : to) {
    while (a != from.end() && a->first < id) ++a;
    if (a == from.end()) break;
    if (a->first == id) common.push_back({ray, a->second});
  }
  return common;
}

// Residuals with their derivatives by a rotation of the camera and by the lidar's motion.
struct Row {
  double r;
  Eigen::Matrix<double, 1, 3> J_rotation;
  RowVector6d J_motion;
};

std::vector<Row> Linearize(const std::vector<Epipolar>& rays, const Rigid3d& T_from_to,
                           const Rigid3d& T_cam_lidar) {
  const Rigid3d T_camfrom_camto = T_cam_lidar * T_from_to * T_cam_lidar.Inverse();
  const Eigen::Vector3d forward = T_camfrom_camto.t().normalized();
  // Exp(w) T Exp(-w) = T Exp(Ad(T^-1) w) Exp(-w).
  const Matrix6d by_rotation = T_camfrom_camto.Inverse().Adjoint() - Matrix6d::Identity();
  const Matrix6d by_motion = T_cam_lidar.Adjoint();
  std::vector<Row> rows;
  rows.reserve(rays.size());
  for (const Epipolar& pair : rays) {
    if (forward.cross(pair.ray_cam_ref).norm() < kMinSine) continue;
    if (forward.cross(T_camfrom_camto.q() * pair.ray_cam).norm() < kMinSine) continue;
    const Residual<1> residual = Evaluate(pair, T_camfrom_camto, Rigid3d(), Matrix6d::Identity());
    rows.push_back({residual.r[0], residual.J * by_rotation.leftCols<3>(), residual.J * by_motion});
  }
  return rows;
}

// Standard deviation of the residuals, from their median.
double RobustSigma(const std::vector<Row>& rows) {
  std::vector<double> absolute;
  absolute.reserve(rows.size());
  for (const Row& row : rows) absolute.push_back(std::abs(row.r));
  const auto middle = absolute.begin() + static_cast<std::ptrdiff_t>(absolute.size() / 2);
  std::nth_element(absolute.begin(), middle, absolute.end());
  return kMadToSigma * *middle;
}

}  // namespace

void ExtrinsicCalibrationOptions::Check() const {
  TVL_CHECK_INPUT(window_m > 0.0) << "extrinsics.window_m: must be positive";
  TVL_CHECK_INPUT(max_frames >= 1) << "extrinsics.max_frames: must be at least 1";
  TVL_CHECK_INPUT(min_tracks >= 8) << "extrinsics.min_tracks: must be at least 8";
  TVL_CHECK_INPUT(corner_sigma_px > 0.0) << "extrinsics.corner_sigma_px: must be positive";
  TVL_CHECK_INPUT(motion_sigma_rad > 0.0) << "extrinsics.motion_sigma_rad: must be positive";
  TVL_CHECK_INPUT(motion_sigma_share > 0.0) << "extrinsics.motion_sigma_share: must be positive";
  TVL_CHECK_INPUT(prior_rad > 0.0) << "extrinsics.prior_rad: must be positive";
  TVL_CHECK_INPUT(bias_rad >= 0.0) << "extrinsics.bias_rad: must not be negative";
  TVL_CHECK_INPUT(memory_windows >= 1.0) << "extrinsics.memory_windows: must be at least 1";
  TVL_CHECK_INPUT(doubt_significance > 0.0) << "extrinsics.doubt_significance: must be positive";
  TVL_CHECK_INPUT(min_significance >= doubt_significance)
      << "extrinsics.min_significance: must be at least doubt_significance";
  edges.Check();
  offset.Check();
}

ExtrinsicCalibration::ExtrinsicCalibration(const Calibration& given,
                                           const ExtrinsicCalibrationOptions& options)
    : options_(options),
      given_(given.T_cam_lidar),
      T_cam_lidar_(given.T_cam_lidar),
      corner_sigma_rad_(options.corner_sigma_px / given.camera.fx_px),
      edges_(options.edges),
      offset_(options.offset) {
  options_.Check();
}

bool ExtrinsicCalibration::Add(const FeatureTracks& tracks, const Rigid3d& T_odom_lidar) {
  if (!options_.enabled) return false;
  View view{T_odom_lidar, {}};
  view.rays_cam.reserve(tracks.tracks.size());
  for (const FeatureTrack& track : tracks.tracks) {
    view.rays_cam.emplace_back(track.id, track.ray_cam.homogeneous().normalized());
  }
  views_.push_back(std::move(view));
  if (static_cast<int>(views_.size()) > options_.max_frames + 1) views_.pop_front();
  const View* start = FindStart();
  if (start == nullptr) return false;
  Compare(*start, views_.back());
  views_.erase(views_.begin(), views_.end() - 1);  // the next window begins here
  return Apply();
}

bool ExtrinsicCalibration::WantsEdges(const Rigid3d& T_odom_lidar) {
  return options_.enabled && options_.use_edges && edges_.IsDue(T_odom_lidar);
}

bool ExtrinsicCalibration::AddEdges(EdgeProfiles edges) {
  const EdgeReading reading{applied_rad_, applied_delay_s_};
  const bool is_new = offset_.Add(edges, reading);
  const CameraOffsetEstimate& offset = offset_.estimate();
  DelayBelief belief;
  if (IsDelayObserved(offset)) belief = {offset.delay_s, offset.delay_sigma_s};
  edges_.Add(std::move(edges), reading, belief);
  const bool has_changed = is_new && ApplyDelay();
  return Apply() || has_changed;
}

const ExtrinsicCalibration::View* ExtrinsicCalibration::FindStart() const {
  for (auto view = views_.rbegin(); view != views_.rend(); ++view) {
    const Eigen::Vector3d way_m = view->T_odom_lidar.t() - views_.back().T_odom_lidar.t();
    if (way_m.norm() >= options_.window_m) return &*view;
  }
  return nullptr;
}

void ExtrinsicCalibration::Compare(const View& from, const View& to) {
  const Rigid3d T_from_to = from.T_odom_lidar.Inverse() * to.T_odom_lidar;
  const std::vector<Row> rows =
      Linearize(CommonRays(from.rays_cam, to.rays_cam), T_from_to, T_cam_lidar_);
  if (static_cast<int>(rows.size()) < options_.min_tracks) return;
  // Both rays have noise. Extrinsics that are far off make all residuals large: no outliers.
  const double sigma = std::max(std::sqrt(2.0) * corner_sigma_rad_, RobustSigma(rows));
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 3> H_cross = Eigen::Matrix<double, 6, 3>::Zero();
  Matrix6d H_motion = Matrix6d::Zero();
  Vector6d b_motion = Vector6d::Zero();
  const double motion_sigma_m = options_.motion_sigma_share * T_from_to.t().norm();
  H_motion.diagonal().head<3>().setConstant(std::pow(options_.motion_sigma_rad, -2));
  H_motion.diagonal().tail<3>().setConstant(std::pow(motion_sigma_m, -2));
  for (const Row& row : rows) {
    const double whitened = row.r / sigma;
    const double weight = Cauchy(whitened * whitened, kKernelSigmas).weight / (sigma * sigma);
    H += weight * row.J_rotation.transpose() * row.J_rotation;
    b += weight * row.r * row.J_rotation.transpose();
    H_cross += weight * row.J_motion.transpose() * row.J_rotation;
    H_motion += weight * row.J_motion.transpose() * row.J_motion;
    b_motion += weight * row.r * row.J_motion.transpose();
  }
  const Eigen::LDLT<Matrix6d> solver(H_motion);
  const double kept = std::exp(-1.0 / options_.memory_windows);
  H_ = (kept * H_ + H - H_cross.transpose() * solver.solve(H_cross)).eval();
  b_ = (kept * b_ + b - H_cross.transpose() * solver.solve(b_motion)).eval();
  ++windows_;
}

Eigen::Matrix3d ExtrinsicCalibration::EdgeInformation() const {
  const EdgeEstimate& edges = edges_.estimate();
  if (edges.images == 0 || windows_ == 0) return edges.information;
  const Eigen::Matrix3d prior = std::pow(options_.prior_rad, -2) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d by_tracks = (H_ + prior).inverse();
  const Eigen::Vector3d apart_rad = edges.rotation_rad - applied_rad_ + by_tracks * b_;
  const double squared =
      apart_rad.dot((by_tracks + edges.information.inverse()).ldlt().solve(apart_rad));
  if (squared > kContradictionSigmas * kContradictionSigmas) return Eigen::Matrix3d::Zero();
  return edges.information;
}

Eigen::Matrix3d ExtrinsicCalibration::Information() const {
  return H_ + EdgeInformation() + std::pow(options_.prior_rad, -2) * Eigen::Matrix3d::Identity();
}

Eigen::Vector3d ExtrinsicCalibration::Remaining() const {
  const Eigen::Vector3d by_edges_rad = edges_.estimate().rotation_rad - applied_rad_;
  return Information().ldlt().solve(EdgeInformation() * by_edges_rad - b_);
}

Eigen::Matrix3d ExtrinsicCalibration::Covariance() const {
  return Information().inverse() +
         options_.bias_rad * options_.bias_rad * Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d ExtrinsicCalibration::RemainingError() const {
  if (!in_doubt_) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d left_rad = Remaining();
  return Covariance() + left_rad * left_rad.transpose();
}

bool ExtrinsicCalibration::Apply() {
  const Eigen::Vector3d correction_rad = Remaining();
  const double significance =
      std::sqrt(correction_rad.dot(Covariance().ldlt().solve(correction_rad)));
  in_doubt_ = in_doubt_ || significance > options_.doubt_significance;
  if (significance < options_.min_significance) return false;
  T_cam_lidar_ = Rigid3d(ExpSo3(correction_rad), Eigen::Vector3d::Zero()) * T_cam_lidar_;
  applied_rad_ = LogSo3((T_cam_lidar_ * given_.Inverse()).q());
  b_ = kKeptAfterCorrection * (b_ + H_ * correction_rad).eval();
  H_ *= kKeptAfterCorrection;
  return true;
}

bool ExtrinsicCalibration::ApplyDelay() {
  const CameraOffsetEstimate& offset = offset_.estimate();
  if (!IsDelayObserved(offset)) return false;
  const double least_s = options_.offset.min_significance * offset.delay_sigma_s;
  if (std::abs(offset.delay_s) < least_s) return false;
  const double change_s = offset.delay_s - applied_delay_s_;
  if (std::abs(change_s) < kSameDelaySigmas * offset.delay_sigma_s) return false;
  applied_delay_s_ = offset.delay_s;
  views_.clear();
  return true;
}

ExtrinsicEstimate ExtrinsicCalibration::estimate() const {
  ExtrinsicEstimate estimate;
  estimate.rotation_rad = LogSo3(ExpSo3(Remaining()) * (T_cam_lidar_ * given_.Inverse()).q());
  estimate.applied_rad = applied_rad_;
  estimate.sigma_rad = Covariance().diagonal().cwiseSqrt();
  estimate.windows = windows_;
  estimate.edge_images = edges_.estimate().images;
  estimate.offset = offset_.estimate();
  estimate.offset.applied_delay_s = applied_delay_s_;
  return estimate;
}

}  // namespace tvl
