#include "tvl/registration/extrinsic_check.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Across and up the windows speak for themselves: nothing is expected within this reach.
constexpr double kReach_rad = 0.035;  // 2 deg
// Scatter of this share of the bias adds a tenth to the standard deviation: more windows hardly
// tell more.
constexpr double kEnoughShare = 0.5;
constexpr size_t kMaxWindows = 50;  // 200 m: where they tell too little the oldest is let go

}  // namespace

void ExtrinsicCheckOptions::Check() const {
  TVL_CHECK_INPUT(bias_rad > 0.0) << "extrinsics.check.bias_rad: must be positive";
  TVL_CHECK_INPUT(min_windows >= 1) << "extrinsics.check.min_windows: must be at least 1";
}

ExtrinsicCheck::ExtrinsicCheck(const ExtrinsicCheckOptions& options, const HandEyeOptions& hand_eye,
                               double prior_rad, double min_significance)
    : options_(options),
      hand_eye_(hand_eye),
      prior_rad_(prior_rad),
      min_significance_(min_significance),
      views_(hand_eye) {
  options_.Check();
}

// Gauss-Newton: far from where the camera points a robust kernel takes what tells most for
// outliers.
ExtrinsicCheck::Error ExtrinsicCheck::Solve(const Rigid3d& T_cam_lidar) const {
  constexpr int kIterations = 4;
  const double reach = std::pow(kReach_rad, -2);
  const Eigen::Matrix3d prior =
      Eigen::Vector3d(reach, reach, std::pow(prior_rad_, -2)).asDiagonal();
  Error error{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  for (int i = 0; i < kIterations; ++i) {
    const Rigid3d T_turned =
        Rigid3d(ExpSo3(error.rotation_rad), Eigen::Vector3d::Zero()) * T_cam_lidar;
    Eigen::Matrix3d H = prior;
    Eigen::Vector3d b = prior * error.rotation_rad;
    for (const HandEyeWindow& window : windows_) {
      const std::optional<HandEyeEquations> equations = Linearize(window, T_turned, hand_eye_);
      if (!equations) continue;
      H += equations->H;
      b += equations->b;
    }
    error.scatter = H.inverse();
    error.rotation_rad = LogSo3(ExpSo3(-error.scatter * b) * ExpSo3(error.rotation_rad));
  }
  return error;
}

std::optional<Eigen::Vector3d> ExtrinsicCheck::Add(const FeatureTracks& tracks,
                                                   const LidarPose& pose,
                                                   const Rigid3d& T_cam_lidar) {
  if (!IsDue()) return std::nullopt;
  std::optional<HandEyeWindow> window = views_.Add(tracks, pose);
  if (!window || !Linearize(*window, T_cam_lidar, hand_eye_)) return std::nullopt;
  windows_.push_back(std::move(*window));
  if (windows_.size() > kMaxWindows) windows_.erase(windows_.begin());
  const Error error = Solve(T_cam_lidar);
  const Eigen::Matrix2d covariance = error.scatter.topLeftCorner<2, 2>() +
                                     std::pow(options_.bias_rad, 2) * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d observed_rad = error.rotation_rad.head<2>();
  const double significance = std::sqrt(observed_rad.dot(covariance.ldlt().solve(observed_rad)));
  if (static_cast<int>(windows_.size()) < options_.min_windows) return std::nullopt;
  if (significance >= min_significance_) {
    windows_.clear();
    return error.rotation_rad;
  }
  const double enough_rad = kEnoughShare * options_.bias_rad;
  has_passed_ = std::sqrt(error.scatter.diagonal().head<2>().maxCoeff()) < enough_rad;
  if (has_passed_) windows_.clear();
  return std::nullopt;
}

}  // namespace tvl
