#include "tvl/loop/pnp.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/factors/reprojection.h"
#include "tvl/geometry/robust.h"
#include "tvl/optim/pose_solver.h"

namespace tvl {
namespace {

// A point with depth in one image and its ray in the other.
struct Sighting {
  bool in_history = true;  // which image knows the depth
  Eigen::Vector3d p_cam;   // there, m
  Eigen::Vector2d ray;     // in the other one
};

Eigen::Vector3d PointAt(const Eigen::Vector2d& ray, double depth_m) {
  return depth_m * ray.homogeneous();
}

// One a match that has a depth; the history's where both have.
std::vector<Sighting> MakeSightings(const std::vector<PnpMatch>& matches) {
  std::vector<Sighting> sightings;
  for (const PnpMatch& m : matches) {
    const bool has_history = m.depth_history_m > 0.0, has_current = m.depth_current_m > 0.0;
    if (!has_history && !has_current) continue;
    if (has_history) {
      sightings.push_back({true, PointAt(m.ray_history, m.depth_history_m), m.ray_current});
    } else {
      sightings.push_back({false, PointAt(m.ray_current, m.depth_current_m), m.ray_history});
    }
  }
  return sightings;
}

double SquaredError(const Sighting& s, const Rigid3d& T_hc, const Rigid3d& T_ch) {
  const Eigen::Vector3d p = s.in_history ? T_ch * s.p_cam : T_hc * s.p_cam;
  if (p.z() < kMinProjectionDepth_m) return 1e9;
  return (p.head<2>() / p.z() - s.ray).squaredNorm();
}

// Truncated squared errors (MSAC): less is better. With the number of those below the bound.
struct Support {
  double cost = 0.0;
  int inliers = 0;
};

Support Judge(const std::vector<Sighting>& sightings, const Rigid3d& T_hc, double max_error_rad) {
  const Rigid3d T_ch = T_hc.Inverse();
  const double bound_sq = max_error_rad * max_error_rad;
  Support support;
  for (const Sighting& s : sightings) {
    const double error_sq = SquaredError(s, T_hc, T_ch);
    support.cost += std::min(error_sq, bound_sq);
    support.inliers += error_sq < bound_sq ? 1 : 0;
  }
  return support;
}

// Three different members of `set`, which holds at least three.
std::array<int, 3> DrawSample(const std::vector<int>& set, Rng& rng) {
  const auto n = static_cast<int64_t>(set.size());
  std::array<int64_t, 3> at{rng.Integer(n), 0, 0};
  do at[1] = rng.Integer(n);
  while (at[1] == at[0]);
  do at[2] = rng.Integer(n);
  while (at[2] == at[0] || at[2] == at[1]);
  const auto member = [&](int64_t i) { return set[static_cast<size_t>(i)]; };
  return {member(at[0]), member(at[1]), member(at[2])};
}

// Up to four poses that map the three points onto their rays.
std::vector<Rigid3d> PosesOf(const std::vector<Sighting>& sightings,
                             const std::array<int, 3>& sample) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;
  for (const int i : sample) {
    const Sighting& s = sightings[static_cast<size_t>(i)];
    points.emplace_back(s.p_cam.x(), s.p_cam.y(), s.p_cam.z());
    rays.emplace_back(s.ray.x(), s.ray.y());
  }
  std::vector<cv::Mat> rotations, translations;
  cv::solveP3P(points, rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations,
               cv::SOLVEPNP_AP3P);
  std::vector<Rigid3d> poses;
  for (size_t i = 0; i < rotations.size(); ++i) {
    Eigen::Vector3d rotation, translation;
    cv::cv2eigen(rotations[i], rotation);
    cv::cv2eigen(translations[i], translation);
    if (!rotation.allFinite() || !translation.allFinite()) continue;
    const Rigid3d T_ray_point(ExpSo3(rotation), translation);
    const bool in_history = sightings[static_cast<size_t>(sample[0])].in_history;
    poses.push_back(in_history ? T_ray_point.Inverse() : T_ray_point);
  }
  return poses;
}

// Samples needed until one is free of outliers, as far as the best pose so far tells.
int IterationsNeeded(int inliers, size_t points, const PnpOptions& options) {
  const double share = static_cast<double>(inliers) / static_cast<double>(points);
  const double all_good = std::pow(share, 3.0);
  if (all_good > 1.0 - 1e-9) return 1;
  if (all_good < 1e-9) return options.max_iterations;
  const double needed = std::log(1.0 - options.confidence) / std::log(1.0 - all_good);
  return std::min(options.max_iterations, static_cast<int>(std::ceil(needed)));
}

// The pose with the best support among those of random samples. Depths of the history and of the
// current image take turns as often as there are points of each.
Rigid3d SearchPose(const std::vector<Sighting>& sightings, const PnpOptions& options) {
  std::vector<int> in_history, in_current;
  for (size_t i = 0; i < sightings.size(); ++i) {
    (sightings[i].in_history ? in_history : in_current).push_back(static_cast<int>(i));
  }
  Rng rng(static_cast<uint64_t>(options.seed));
  Rigid3d best;
  Support best_support{1e300, 0};
  for (int i = 0, needed = options.max_iterations; i < needed; ++i) {
    const bool from_current =
        in_history.size() < 3 ||
        (in_current.size() >= 3 && rng.Integer(static_cast<int64_t>(sightings.size())) <
                                       static_cast<int64_t>(in_current.size()));
    const auto sample = DrawSample(from_current ? in_current : in_history, rng);
    for (const Rigid3d& pose : PosesOf(sightings, sample)) {
      const Support support = Judge(sightings, pose, options.max_error_rad);
      if (support.cost >= best_support.cost) continue;
      best = pose;
      best_support = support;
      needed = IterationsNeeded(support.inliers, sightings.size(), options);
    }
  }
  return best;
}

// In units of max_error_rad. Matches far off take no part in the refinement; most good ones lie
// within a third of the bound.
constexpr double kFarthest_sq = 9.0;
constexpr double kHuber = 0.3;

template <typename Factor>
NormalEquations TermOf(const Factor& factor, const Rigid3d& T_hc, double max_error_rad) {
  NormalEquations term;
  const ProjectedResidual residual = Evaluate(factor, T_hc, Rigid3d());
  const double r_sq = residual.depth_m < kMinProjectionDepth_m
                          ? kFarthest_sq
                          : residual.r.squaredNorm() / (max_error_rad * max_error_rad);
  if (r_sq >= kFarthest_sq) {  // neither wanted nor pulled in: a constant
    term.cost = 0.5 * Huber(kFarthest_sq, kHuber).rho;
    return term;
  }
  const RobustValue robust = Huber(r_sq, kHuber);
  const double weight = robust.weight / (max_error_rad * max_error_rad);
  term.H = weight * residual.J.transpose() * residual.J;
  term.b = weight * residual.J.transpose() * residual.r;
  term.cost = 0.5 * robust.rho;
  return term;
}

// Least squares over the points near the pose found.
Rigid3d Refine(const std::vector<Sighting>& sightings, const Rigid3d& T_hc,
               const PnpOptions& options) {
  const auto linearize = [&](const Rigid3d& T) {
    NormalEquations sum;
    for (const Sighting& s : sightings) {
      if (s.in_history) {
        sum += TermOf(Reprojection{s.p_cam, s.ray}, T, options.max_error_rad);
      } else {
        sum += TermOf(InverseReprojection{s.p_cam, s.ray}, T, options.max_error_rad);
      }
    }
    return sum;
  };
  PoseSolverOptions solver;
  solver.max_iterations = 10;
  return SolvePose(T_hc, linearize, solver).T;
}

}  // namespace

void PnpOptions::Check() const {
  TVL_CHECK_INPUT(max_error_rad > 0.0) << "max_error_rad: must be positive, is " << max_error_rad;
  TVL_CHECK_INPUT(min_inliers >= 6) << "min_inliers: must be at least 6, is " << min_inliers;
  TVL_CHECK_INPUT(min_inlier_share >= 0.0 && min_inlier_share <= 1.0)
      << "min_inlier_share: must lie in 0..1, is " << min_inlier_share;
  TVL_CHECK_INPUT(confidence > 0.0 && confidence < 1.0)
      << "confidence: must lie between 0 and 1, is " << confidence;
  TVL_CHECK_INPUT(max_iterations >= 1)
      << "max_iterations: must be at least 1, is " << max_iterations;
}

PnpResult SolvePnp(const std::vector<PnpMatch>& matches, const PnpOptions& options) {
  const std::vector<Sighting> sightings = MakeSightings(matches);
  PnpResult result;
  result.points = static_cast<int>(sightings.size());
  if (result.points < options.min_inliers) return result;
  result.T_history_current = Refine(sightings, SearchPose(sightings, options), options);
  result.inliers = Judge(sightings, result.T_history_current, options.max_error_rad).inliers;
  const bool is_enough =
      result.inliers >= options.min_inliers &&
      result.inliers >= options.min_inlier_share * static_cast<double>(result.points);
  result.status = is_enough ? PnpStatus::kFound : PnpStatus::kFewInliers;
  return result;
}

}  // namespace tvl
