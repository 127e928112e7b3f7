#include "tvl/registration/extrinsic_calibration.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/factors/epipolar.h"
#include "tvl/geometry/robust.h"

namespace tvl {
namespace {

// Once a correction is in use, what led to it counts for this share: it was measured with poses
// that the wrong extrinsics had pulled along, and falls short.
constexpr double kKeptAfterCorrection = 0.3;
// Edges and tracks that differ by more standard deviations do not look at the same: tracks count.
constexpr double kContradictionSigmas = 4.0;
constexpr double kSameDelaySigmas = 0.5;  // a delay that is known by so much better is not new

HandEyeOptions HandEyeOf(const ExtrinsicCalibrationOptions& options, const Calibration& given) {
  HandEyeOptions out;
  out.window_m = options.window_m;
  out.max_frames = options.max_frames;
  out.min_tracks = options.min_tracks;
  out.corner_sigma_rad = options.corner_sigma_px / given.camera.fx_px;
  out.motion_sigma_rad = options.motion_sigma_rad;
  out.motion_sigma_share = options.motion_sigma_share;
  return out;
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
  check.Check();
}

ExtrinsicCalibration::ExtrinsicCalibration(const Calibration& given,
                                           const ExtrinsicCalibrationOptions& options)
    : options_(options),
      given_(given.T_cam_lidar),
      T_cam_lidar_(given.T_cam_lidar),
      hand_eye_(HandEyeOf(options, given)),
      views_(hand_eye_),
      check_(options.check, hand_eye_, options.prior_rad, options.min_significance),
      edges_(options.edges),
      offset_(options.offset) {
  options_.Check();
}

bool ExtrinsicCalibration::Add(const FeatureTracks& tracks, const Rigid3d& T_odom_lidar) {
  if (!options_.enabled) return false;
  const std::optional<HandEyeWindow> window = views_.Add(tracks, {T_odom_lidar});
  if (!window) return false;
  if (const auto equations = Linearize(*window, T_cam_lidar_, hand_eye_)) {
    const double kept = std::exp(-1.0 / options_.memory_windows);
    H_ = (kept * H_ + equations->H).eval();
    b_ = (kept * b_ + equations->b).eval();
    ++windows_;
  }
  return Apply();
}

bool ExtrinsicCalibration::AddLidarOnly(const FeatureTracks& tracks, const LidarPose& pose) {
  if (!options_.enabled) return false;
  const std::optional<Eigen::Vector3d> error_rad = check_.Add(tracks, pose, T_cam_lidar_);
  if (!error_rad) return false;
  in_doubt_ = true;
  Turn(*error_rad, 0.0);  // the poses so far have followed the wrong camera ...
  views_.Forget();        // ... and so would a window that begins with one of them
  return true;
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
  Turn(correction_rad, kKeptAfterCorrection);
  return true;
}

void ExtrinsicCalibration::Turn(const Eigen::Vector3d& correction_rad, double kept) {
  T_cam_lidar_ = Rigid3d(ExpSo3(correction_rad), Eigen::Vector3d::Zero()) * T_cam_lidar_;
  applied_rad_ = LogSo3((T_cam_lidar_ * given_.Inverse()).q());
  b_ = kept * (b_ + H_ * correction_rad).eval();
  H_ *= kept;
}

bool ExtrinsicCalibration::ApplyDelay() {
  const CameraOffsetEstimate& offset = offset_.estimate();
  if (!IsDelayObserved(offset)) return false;
  const double least_s = options_.offset.min_significance * offset.delay_sigma_s;
  if (std::abs(offset.delay_s) < least_s) return false;
  const double change_s = offset.delay_s - applied_delay_s_;
  if (std::abs(change_s) < kSameDelaySigmas * offset.delay_sigma_s) return false;
  applied_delay_s_ = offset.delay_s;
  views_.Forget();
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
