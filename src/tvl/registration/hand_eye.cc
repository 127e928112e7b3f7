#include "tvl/registration/hand_eye.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tvl/geometry/robust.h"

namespace tvl {
namespace {

// Rays nearer to the direction of motion (sine of the angle) hardly tell their epipolar plane.
constexpr double kMinSine = 0.03;
constexpr double kKernelSigmas = 2.0;
constexpr double kMadToSigma = 1.4826;  // of a normal distribution

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

std::vector<Row> RowsOf(const std::vector<Epipolar>& rays, const Rigid3d& T_from_to,
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

std::optional<HandEyeWindow> HandEyeWindows::Add(const FeatureTracks& tracks,
                                                 const LidarPose& pose) {
  View view{pose, {}};
  view.rays_cam.reserve(tracks.tracks.size());
  for (const FeatureTrack& track : tracks.tracks) {
    view.rays_cam.emplace_back(track.id, track.ray_cam.homogeneous().normalized());
  }
  views_.push_back(std::move(view));
  if (static_cast<int>(views_.size()) > options_.max_frames + 1) views_.pop_front();
  const View* start = FindStart();
  if (start == nullptr) return std::nullopt;
  HandEyeWindow window = WindowBetween(*start, views_.back());
  views_.erase(views_.begin(), views_.end() - 1);  // the next window begins here
  return window;
}

const HandEyeWindows::View* HandEyeWindows::FindStart() const {
  const Eigen::Vector3d& end_m = views_.back().pose.T_odom_lidar.t();
  for (auto view = views_.rbegin(); view != views_.rend(); ++view) {
    if ((view->pose.T_odom_lidar.t() - end_m).norm() >= options_.window_m) return &*view;
  }
  return nullptr;
}

HandEyeWindow HandEyeWindows::WindowBetween(const View& from, const View& to) const {
  HandEyeWindow window;
  window.rays = CommonRays(from.rays_cam, to.rays_cam);
  window.T_from_to = from.pose.T_odom_lidar.Inverse() * to.pose.T_odom_lidar;
  const double motion_sigma_m = options_.motion_sigma_share * window.T_from_to.t().norm();
  window.information.setZero();
  window.information.diagonal().head<3>().setConstant(std::pow(options_.motion_sigma_rad, -2));
  window.information.diagonal().tail<3>().setConstant(std::pow(motion_sigma_m, -2));
  if (from.pose.covariance.isZero(0.0) && to.pose.covariance.isZero(0.0)) return window;
  // T_from Exp(a), T_to Exp(b): the motion is T_from_to Exp(-Ad(T_from_to^-1) a) Exp(b).
  const Matrix6d Ad = window.T_from_to.Inverse().Adjoint();
  Matrix6d covariance = to.pose.covariance + Ad * from.pose.covariance * Ad.transpose();
  covariance.diagonal() += window.information.diagonal().cwiseInverse();
  window.information = covariance.ldlt().solve(Matrix6d::Identity());
  return window;
}

std::optional<HandEyeEquations> Linearize(const HandEyeWindow& window, const Rigid3d& T_cam_lidar,
                                          const HandEyeOptions& options) {
  const std::vector<Row> rows = RowsOf(window.rays, window.T_from_to, T_cam_lidar);
  if (static_cast<int>(rows.size()) < options.min_tracks) return std::nullopt;
  // Both rays have noise. Extrinsics that are far off make all residuals large: no outliers.
  const double sigma = std::max(std::sqrt(2.0) * options.corner_sigma_rad, RobustSigma(rows));
  HandEyeEquations sum;
  Eigen::Matrix<double, 6, 3> H_cross = Eigen::Matrix<double, 6, 3>::Zero();
  Matrix6d H_motion = window.information;
  Vector6d b_motion = Vector6d::Zero();
  for (const Row& row : rows) {
    const double whitened = row.r / sigma;
    const double weight = Cauchy(whitened * whitened, kKernelSigmas).weight / (sigma * sigma);
    sum.H += weight * row.J_rotation.transpose() * row.J_rotation;
    sum.b += weight * row.r * row.J_rotation.transpose();
    H_cross += weight * row.J_motion.transpose() * row.J_rotation;
    H_motion += weight * row.J_motion.transpose() * row.J_motion;
    b_motion += weight * row.r * row.J_motion.transpose();
  }
  const Eigen::LDLT<Matrix6d> solver(H_motion);
  sum.H -= H_cross.transpose() * solver.solve(H_cross);
  sum.b -= H_cross.transpose() * solver.solve(b_motion);
  return sum;
}

}  // namespace tvl
