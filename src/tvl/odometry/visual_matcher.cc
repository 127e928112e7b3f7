#include "tvl/odometry/visual_matcher.h"

#include "tvl/base/check.h"

namespace tvl {
namespace {

bool HasDepth(const VisualDepth& depth, const VisualMatchOptions& options) {
  return depth.status == DepthStatus::kOk &&
         depth.sigma_m < options.max_relative_sigma * depth.depth_m;
}

// A feature with depth in the camera frame and its covariance along the ray.
struct Point {
  Eigen::Vector3d p_cam;
  Eigen::Matrix3d covariance_m2;
};

Point Lift(const FeatureTrack& track, const VisualDepth& depth) {
  const Eigen::Vector3d ray = track.ray_cam.homogeneous();
  return {depth.depth_m * ray, depth.sigma_m * depth.sigma_m * ray * ray.transpose()};
}

// Adds the match of one track seen in both images.
class Builder {
 public:
  Builder(const Calibration& calibration, const Rigid3d& T_prev_cur,
          const VisualMatchOptions& options)
      : T_lidar_cam_(calibration.T_cam_lidar.Inverse()),
        T_camprev_cam_(calibration.T_cam_lidar * T_prev_cur * T_lidar_cam_),
        sigma_(options.sigma_px / calibration.camera.fx_px),
        baseline_(T_prev_cur.t().norm() > options.min_baseline_m) {}

  void AddForward(const FeatureTrack& before, const VisualDepth& depth, const FeatureTrack& now,
                  size_t source) {
    const Point point = Lift(before, depth);
    const Eigen::Vector3d p_now = T_camprev_cam_.Inverse() * point.p_cam;
    if (p_now.z() < kMinProjectionDepth_m) return;
    const Eigen::Matrix<double, 2, 3> J =
        ProjectionJacobian(p_now) * T_camprev_cam_.R().transpose();
    matches_.forward.push_back({{T_lidar_cam_ * point.p_cam, now.ray_cam},
                                RayInformation(sigma_, J, point.covariance_m2),
                                source});
  }
  void AddInverse(const FeatureTrack& before, const FeatureTrack& now, const VisualDepth& depth) {
    const Point point = Lift(now, depth);
    const Eigen::Vector3d p_before = T_camprev_cam_ * point.p_cam;
    if (p_before.z() < kMinProjectionDepth_m) return;
    const Eigen::Matrix<double, 2, 3> J = ProjectionJacobian(p_before) * T_camprev_cam_.R();
    matches_.inverse.push_back({{T_lidar_cam_ * point.p_cam, before.ray_cam},
                                RayInformation(sigma_, J, point.covariance_m2)});
  }
  void AddEpipolar(const FeatureTrack& before, const FeatureTrack& now) {
    if (!baseline_) return;
    matches_.epipolar.push_back(
        {{now.ray_cam.homogeneous().normalized(), before.ray_cam.homogeneous().normalized()},
         1.0 / (sigma_ * sigma_)});
  }
  VisualMatches Take() { return std::move(matches_); }

 private:
  Rigid3d T_lidar_cam_, T_camprev_cam_;
  double sigma_;
  bool baseline_;
  VisualMatches matches_;
};

}  // namespace

void VisualMatchOptions::Check() const {
  TVL_CHECK_INPUT(sigma_px > 0.0) << "odometry.sigma_px: must be positive";
  TVL_CHECK_INPUT(max_relative_sigma > 0.0) << "odometry.max_relative_sigma: must be positive";
  TVL_CHECK_INPUT(min_baseline_m >= 0.0) << "odometry.min_baseline_m: must not be negative";
}

VisualMatches MatchVisual(const VisualFeatures& previous, const VisualFeatures& current,
                          const Calibration& calibration, const Rigid3d& T_prev_cur,
                          const VisualMatchOptions& options) {
  Builder builder(calibration, T_prev_cur, options);
  const auto& before = previous.tracks.tracks;
  const auto& now = current.tracks.tracks;
  for (size_t i = 0, j = 0; i < before.size() && j < now.size();) {  // both by increasing id
    if (before[i].id != now[j].id) {
      before[i].id < now[j].id ? ++i : ++j;
      continue;
    }
    if (HasDepth(previous.depths[i], options)) {
      builder.AddForward(before[i], previous.depths[i], now[j], j);
    } else if (HasDepth(current.depths[j], options)) {
      builder.AddInverse(before[i], now[j], current.depths[j]);
    } else {
      builder.AddEpipolar(before[i], now[j]);
    }
    ++i;
    ++j;
  }
  return builder.Take();
}

}  // namespace tvl
