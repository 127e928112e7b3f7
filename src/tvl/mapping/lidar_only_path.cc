#include "tvl/mapping/lidar_only_path.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace tvl {
namespace {

// The step as it is believed, one standard deviation. A camera that is 2 deg off turns the way by
// 0.035 of it and leaves the rotation: so wide that the lidar is hardly held back where it says
// anything at all, which is some millimetres.
constexpr double kStepSigma_rad = 0.005;
constexpr double kStepSigma_m = 0.03;
constexpr double kStepSigmaShare = 0.05;

Matrix6d StepCovariance(double step_m) {
  Vector6d sigma;
  sigma.head<3>().setConstant(kStepSigma_rad);
  sigma.tail<3>().setConstant(std::hypot(kStepSigma_m, kStepSigmaShare * step_m));
  return sigma.cwiseAbs2().asDiagonal();
}

ScanToMapOptions WithoutCamera(ScanToMapOptions options) {
  options.use_camera = false;
  return options;
}

}  // namespace

LidarOnlyPath::LidarOnlyPath(const Calibration& calibration, const ScanToMapOptions& scan_to_map,
                             const LocalMapOptions& local_map, const KeyframeOptions& keyframes)
    : calibration_(calibration),
      scan_to_map_(WithoutCamera(scan_to_map)),
      map_options_(local_map),
      keyframe_options_(keyframes),
      no_landmarks_(calibration, LandmarkOptions()),
      map_(local_map) {}

void LidarOnlyPath::Forget() {
  if (keyframes_ == 0) return;
  map_ = LocalMap(map_options_);
  keyframes_ = 0;
}

std::optional<LidarPose> LidarOnlyPath::Add(const MapStepPoints& points,
                                            const std::shared_ptr<const KeyframeCloud>& cloud,
                                            const Rigid3d& T_odom_lidar, const Executor& executor) {
  const Rigid3d T_last_cur = T_odom_last_.Inverse() * T_odom_lidar;
  T_odom_last_ = T_odom_lidar;
  if (keyframes_ == 0) {
    T_own_last_ = Rigid3d();
    path_m_ = 0.0;
    AddToMap(cloud, executor);
    return std::nullopt;
  }
  const double step_m = T_last_cur.t().norm();
  const PosePrior prior{T_own_last_ * T_last_cur, StepCovariance(step_m), step_m};
  const MotionEstimate estimate =
      RefinePose(points, map_, no_landmarks_, {}, calibration_, prior, scan_to_map_, executor)
          .estimate;
  if (estimate.status == EstimateStatus::kPredicted) {
    Forget();
    return std::nullopt;
  }
  T_own_last_ = estimate.T_ref_body;
  path_m_ += step_m;
  if (IsKeyframe(T_own_keyframe_.Inverse() * T_own_last_, static_cast<size_t>(keyframes_),
                 keyframe_options_)) {
    AddToMap(cloud, executor);
  }
  const Matrix6d information =
      estimate.information + prior.covariance.ldlt().solve(Matrix6d::Identity());
  return LidarPose{T_own_last_, information.ldlt().solve(Matrix6d::Identity())};
}

void LidarOnlyPath::AddToMap(const std::shared_ptr<const KeyframeCloud>& cloud,
                             const Executor& executor) {
  map_.Add({keyframes_++, path_m_, T_own_last_, cloud}, executor);
  T_own_keyframe_ = T_own_last_;
}

}  // namespace tvl
