#include "tvl/odometry/road_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr int kIterations = 5;
// That a track agrees is so much more probable if the motion is right (natural logarithm of the
// ratio): by chance one in twenty does.
constexpr double kLogOddsOfTrack = 3.0;

// Tracks of the road seen in both images, as matches of the previous lidar frame.
std::vector<ReprojectionMatch> RoadMatches(const VisualFeatures& previous,
                                           const VisualFeatures& current,
                                           const Calibration& calibration, const Rigid3d& T_guess,
                                           const RoadMotionOptions& options) {
  VisualFeatures road;
  for (size_t i = 0; i < previous.depths.size(); ++i) {
    if (previous.depths[i].label != kLabelGround) continue;
    road.tracks.tracks.push_back(previous.tracks.tracks[i]);
    road.depths.push_back(previous.depths[i]);
  }
  VisualMatchOptions matching;
  matching.sigma_px = options.sigma_px;
  matching.max_relative_sigma = options.max_relative_sigma;
  return MatchVisual(road, current, calibration, T_guess, matching).forward;
}

// Equations of x and y.
struct PlanarEquations {
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  double chi2 = 0.0;
};

PlanarEquations Linearize(const ReprojectionMatch& match, const Rigid3d& T,
                          const Rigid3d& T_cam_lidar) {
  const ProjectedResidual residual = Evaluate(match.factor, T, T_cam_lidar);
  PlanarEquations equations;
  if (residual.depth_m < kMinProjectionDepth_m) {
    equations.chi2 = std::numeric_limits<double>::infinity();
    return equations;
  }
  // A step of the translation is one of the perturbation, seen from the body.
  const Eigen::Matrix<double, 2, 3> J = residual.J.rightCols<3>() * T.R().transpose();
  const Eigen::Matrix2d J_xy = J.leftCols<2>();
  equations.H = J_xy.transpose() * match.information * J_xy;
  equations.b = J_xy.transpose() * match.information * residual.r;
  equations.chi2 = residual.r.dot(match.information * residual.r);
  return equations;
}

Rigid3d Moved(const Rigid3d& T, const Eigen::Vector2d& step_m) {
  return Rigid3d(T.q(), T.t() + Eigen::Vector3d(step_m.x(), step_m.y(), 0.0));
}

// The translation with which one track is where it was seen.
Rigid3d FromOne(const ReprojectionMatch& match, Rigid3d T, const Rigid3d& T_cam_lidar) {
  for (int i = 0; i < kIterations; ++i) {
    const PlanarEquations equations = Linearize(match, T, T_cam_lidar);
    if (!std::isfinite(equations.chi2)) break;
    T = Moved(T, -equations.H.ldlt().solve(equations.b));
  }
  return T;
}

int CountAgreeing(const std::vector<ReprojectionMatch>& matches, const Rigid3d& T,
                  const Rigid3d& T_cam_lidar, double gate) {
  return static_cast<int>(std::count_if(
      matches.begin(), matches.end(),
      [&](const ReprojectionMatch& match) { return Chi2(match, T, T_cam_lidar) < gate; }));
}

// Robust least squares over those that agree, which may change on the way: what is left in the gate
// of things that hardly move, such as a shadow, errs to one side.
RoadMotion Refine(const std::vector<ReprojectionMatch>& matches, Rigid3d T,
                  const Rigid3d& T_cam_lidar, double gate) {
  RoadMotion motion;
  motion.tracks = static_cast<int>(matches.size());
  for (int i = 0; i < kIterations; ++i) {
    PlanarEquations sum;
    for (const ReprojectionMatch& match : matches) {
      const PlanarEquations equations = Linearize(match, T, T_cam_lidar);
      if (equations.chi2 >= gate) continue;
      const double weight = 1.0 / (1.0 + equations.chi2);  // Cauchy, of one standard deviation
      sum.H += weight * equations.H;
      sum.b += weight * equations.b;
    }
    if (sum.H.determinant() <= 0.0) break;
    T = Moved(T, -sum.H.ldlt().solve(sum.b));
    motion.covariance_m2 = sum.H.inverse();
  }
  motion.T_prev_cur = T;
  for (const ReprojectionMatch& match : matches) {
    if (Chi2(match, T, T_cam_lidar) < gate) motion.agreeing.push_back(match.source);
  }
  return motion;
}

}  // namespace

void RoadMotionOptions::Check() const {
  TVL_CHECK_INPUT(sigma_px > 0.0) << "odometry.road.sigma_px: must be positive";
  TVL_CHECK_INPUT(max_relative_sigma > 0.0) << "odometry.road.max_relative_sigma: must be positive";
  TVL_CHECK_INPUT(gate_sigmas > 0.0) << "odometry.road.gate_sigmas: must be positive";
  TVL_CHECK_INPUT(min_tracks >= 2) << "odometry.road.min_tracks: must be at least 2";
  TVL_CHECK_INPUT(min_share > 0.0 && min_share <= 1.0)
      << "odometry.road.min_share: must lie in 0..1, and not be 0";
  TVL_CHECK_INPUT(max_sigma_m > 0.0) << "odometry.road.max_sigma_m: must be positive";
}

Eigen::Matrix2d CovarianceOf(const RoadMotion& road) {
  constexpr double kShared_m = 0.005;
  return 2.0 * road.covariance_m2 + kShared_m * kShared_m * Eigen::Matrix2d::Identity();
}

std::optional<RoadMotion> MeasureRoadMotion(const VisualFeatures& previous,
                                            const VisualFeatures& current,
                                            const Calibration& calibration, const RoadGuess& guess,
                                            const RoadMotionOptions& options) {
  const std::vector<ReprojectionMatch> matches =
      RoadMatches(previous, current, calibration, guess.T_prev_cur, options);
  const double gate = options.gate_sigmas * options.gate_sigmas;
  const auto score = [&](const Rigid3d& T) {
    const Eigen::Vector2d innovation_m = T.t().head<2>() - guess.expected_m;
    return kLogOddsOfTrack * CountAgreeing(matches, T, calibration.T_cam_lidar, gate) -
           0.5 * innovation_m.dot(guess.information * innovation_m);
  };
  Rigid3d best = guess.T_prev_cur;
  double best_score = score(best);
  for (const ReprojectionMatch& match : matches) {
    const Rigid3d T = FromOne(match, guess.T_prev_cur, calibration.T_cam_lidar);
    const double its_score = score(T);
    if (its_score > best_score) best = T, best_score = its_score;
  }
  RoadMotion motion = Refine(matches, best, calibration.T_cam_lidar, gate);
  motion.agreeing_with_guess =
      CountAgreeing(matches, guess.T_prev_cur, calibration.T_cam_lidar, gate);
  const auto agreeing = static_cast<double>(motion.agreeing.size());
  if (agreeing < options.min_tracks || agreeing < options.min_share * motion.tracks) {
    return std::nullopt;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(motion.covariance_m2);
  if (eigen.eigenvalues().maxCoeff() > options.max_sigma_m * options.max_sigma_m) {
    return std::nullopt;
  }
  return motion;
}

}  // namespace tvl
