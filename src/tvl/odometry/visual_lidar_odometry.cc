#include "tvl/odometry/visual_lidar_odometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/factors/pose_prior.h"

namespace tvl {

// Correspondences of one refresh and how to weigh them.
struct VisualLidarOdometry::Problem {
  const OdometryOptions& options;
  const Rigid3d& T_cam_lidar;
  const SweepBins& bins;
  const Executor& executor;
  Rigid3d T_prior;
  bool has_prior = false;
  LaserMatches laser;
  VisualMatches visual;
  Weakness weakness;

  size_t size() const { return laser.planes.size() + laser.lines.size() + visual.size(); }
  LaserSum Laser(const Rigid3d& T) const {
    return Linearize(laser, T, bins, options.kernel_sigmas, executor);
  }
  VisualSum Visual(const Rigid3d& T) const {
    return Linearize(visual, T, T_cam_lidar, options.visual_kernel_sigmas);
  }
  NormalEquations Prior(const Rigid3d& T) const {
    NormalEquations n;
    if (!has_prior) return n;
    Vector6d information;
    information << Eigen::Vector3d::Constant(std::pow(options.prior_sigma_rad, -2)),
        Eigen::Vector3d::Constant(std::pow(options.prior_sigma_m, -2));
    const Residual<6> residual = EvaluatePosePrior(T_prior, T);
    n.H = residual.J.transpose() * information.asDiagonal() * residual.J;
    n.b = residual.J.transpose() * information.asDiagonal() * residual.r;
    n.cost = 0.5 * residual.r.dot(information.asDiagonal() * residual.r);
    return n;
  }
  NormalEquations WithoutCamera(const Rigid3d& T) const {
    NormalEquations sum = Masked(Laser(T).normal, weakness.lidar_mask);
    sum += Prior(T);
    return sum;
  }
  // Drops the visual matches that contradict what laser and prior say near T.
  void GateVisual(const Rigid3d& T) {
    PoseSolverOptions solver;
    solver.max_iterations = 2;
    const PoseSolution alone = SolvePose(
        T, [&](const Rigid3d& at) { return WithoutCamera(at); }, solver);
    const Matrix6d covariance =
        HonestCovariance(alone.at_T.H, alone.T.t().norm(), options.covariance);
    visual = Gate(visual, alone.T, T_cam_lidar, covariance, options.visual_gate_sigmas);
  }
  NormalEquations All(const Rigid3d& T) const {
    NormalEquations sum = Masked(Laser(T).normal, weakness.lidar_mask);
    sum += Visual(T).normal;
    sum += Prior(T);
    return sum;
  }
  PoseSolution Solve(const Rigid3d& T) const {
    PoseSolverOptions solver;
    solver.max_iterations = 3;
    return SolvePose(
        T, [&](const Rigid3d& at) { return All(at); }, solver);
  }
  Matrix6d Covariance(const Rigid3d& T) const {
    return HonestCovariance(All(T).H, T.t().norm(), options.covariance);
  }
  void Describe(const Rigid3d& T, MotionEstimate* estimate) const {
    const LaserSum laser_sum = Laser(T);
    const VisualSum visual_sum = Visual(T);
    const auto rms = [](double sum, size_t n) {
      return n == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(n));
    };
    estimate->T_ref_body = T;
    estimate->covariance = Covariance(T);
    estimate->weak = weakness.directions;
    EstimateEvidence& evidence = estimate->evidence;
    evidence.planes = static_cast<int>(laser.planes.size());
    evidence.edges = static_cast<int>(laser.lines.size());
    evidence.visual = static_cast<int>(visual.size());
    evidence.plane_rms_m = rms(laser_sum.plane_sq_m2, laser.planes.size());
    evidence.edge_rms_m = rms(laser_sum.line_sq_m2, laser.lines.size());
    evidence.visual_rms = rms(visual_sum.squared, static_cast<size_t>(visual_sum.count));
  }
};

// Where an estimate begins.
struct VisualLidarOdometry::Start {
  Rigid3d T_prev_cur;
  bool is_predicted;  // from a known velocity: serves as prior, too
  bool use_camera;
};

struct VisualLidarOdometry::Candidate {
  MotionEstimate estimate;
  // Robust cost a feature, those without a match at a fixed price: to choose among starts.
  double score = 0.0;
};

void OdometryOptions::Check() const {
  laser.Check();
  visual.Check();
  weakness.Check();
  covariance.Check();
  TVL_CHECK_INPUT(kernel_sigmas > 0.0) << "odometry.kernel_sigmas: must be positive";
  TVL_CHECK_INPUT(max_refreshes >= 1) << "odometry.max_refreshes: must be at least 1";
  TVL_CHECK_INPUT(first_gate_m >= last_gate_m && last_gate_m > 0.0)
      << "odometry.first_gate_m, last_gate_m: want first >= last > 0";
  TVL_CHECK_INPUT(prior_sigma_m > 0.0 && prior_sigma_rad > 0.0)
      << "odometry.prior_sigma_m, prior_sigma_rad: must be positive";
}

VisualLidarOdometry::VisualLidarOdometry(const Calibration& calibration,
                                         const OdometryOptions& options)
    : calibration_(calibration), options_(options) {
  options_.Check();
}

void VisualLidarOdometry::Advance(const PreprocessedFrame& frame,
                                  std::vector<Eigen::Vector3f> edges,
                                  std::vector<Eigen::Vector3f> planes) {
  matcher_.reset();
  if (frame.has_scan) {
    matcher_ =
        std::make_unique<LaserMatcher>(RingCloud(std::move(edges), frame.features.less_sharp),
                                       RingCloud(std::move(planes), frame.features.less_flat));
  }
  previous_visual_ = {frame.tracks, frame.depths};
}

void VisualLidarOdometry::Reset() {
  matcher_.reset();
  previous_visual_ = {};
}

double VisualLidarOdometry::Score(const PreprocessedFrame& frame, const Problem& problem,
                                  double cost) {
  constexpr double kUnmatchedCost = 3.0;  // as a residual of about 3 sigma under the kernel
  const double features = static_cast<double>(frame.features.flat.size() +
                                              frame.features.sharp.size() + problem.visual.size());
  const double matched = static_cast<double>(problem.size());
  return (cost + kUnmatchedCost * std::max(0.0, features - matched)) / std::max(1.0, features);
}

VisualLidarOdometry::Problem VisualLidarOdometry::MakeProblem(const Start& start,
                                                              const SweepBins& bins,
                                                              const Executor& executor) const {
  return {options_,
          calibration_.T_cam_lidar,
          bins,
          executor,
          start.T_prev_cur,
          start.is_predicted,
          {},
          {},
          {}};
}

void VisualLidarOdometry::Match(const PreprocessedFrame& frame, const Start& start,
                                const Rigid3d& T_prev_cur, double gate_m, double period_s,
                                Problem* problem) {
  if (matcher_ != nullptr && frame.has_scan) {
    const SweepFeatures features =
        PrepareSweep(frame.features, problem->bins, period_s, T_prev_cur);
    problem->laser = matcher_->Match(features, problem->bins, T_prev_cur, gate_m, options_.laser);
  }
  if (options_.use_camera && start.use_camera) {
    problem->visual = MatchVisual(previous_visual_, {frame.tracks, frame.depths}, calibration_,
                                  T_prev_cur, options_.visual);
  }
  problem->weakness = AnalyseWeakness(problem->Laser(T_prev_cur),
                                      problem->Visual(T_prev_cur).normal, options_.weakness);
  if (problem->visual.size() > 0) problem->GateVisual(T_prev_cur);
}

VisualLidarOdometry::Candidate VisualLidarOdometry::EstimateFrom(const PreprocessedFrame& frame,
                                                                 const Start& start,
                                                                 const SweepBins& bins,
                                                                 double period_s,
                                                                 const Executor& executor) {
  Problem problem = MakeProblem(start, bins, executor);
  Rigid3d T = start.T_prev_cur;
  Candidate candidate;
  candidate.estimate.status = EstimateStatus::kNotConverged;
  double gate_m = options_.first_gate_m * (start.is_predicted ? 1.0 : 2.0);
  int refreshes = 0;
  while (refreshes < options_.max_refreshes &&
         candidate.estimate.status != EstimateStatus::kConverged) {
    Match(frame, start, T, gate_m, period_s, &problem);
    if (problem.size() < static_cast<size_t>(options_.min_matches)) {
      candidate.estimate.status = EstimateStatus::kPredicted;
      candidate.estimate.T_ref_body = start.T_prev_cur;
      candidate.estimate.covariance = problem.Covariance(start.T_prev_cur);
      candidate.score = std::numeric_limits<double>::max();
      return candidate;
    }
    const PoseSolution solution = problem.Solve(T);
    const Vector6d step = (T.Inverse() * solution.T).Log();
    if (step.head<3>().norm() < options_.stop_rotation_rad &&
        step.tail<3>().norm() < options_.stop_translation_m) {
      candidate.estimate.status = EstimateStatus::kConverged;
    }
    T = solution.T;
    candidate.score = Score(frame, problem, solution.at_T.cost);
    gate_m = std::max(options_.last_gate_m, 0.5 * gate_m);
    ++refreshes;
  }
  problem.Describe(T, &candidate.estimate);
  candidate.estimate.evidence.iterations = refreshes;
  return candidate;
}

MotionEstimate VisualLidarOdometry::Estimate(const PreprocessedFrame& frame,
                                             const MotionGuess& guess, const SweepBins& bins,
                                             double period_s, const Executor& executor) {
  if (guess.known) {
    return EstimateFrom(frame, {guess.T_prev_cur, true, true}, bins, period_s, executor).estimate;
  }
  // Laser alone first: without a known motion nothing tells features on moving cars from others.
  constexpr double kStartSpacing_m = 0.75;  // half of the first gate
  Candidate best = EstimateFrom(frame, {Rigid3d(), false, false}, bins, period_s, executor);
  for (double x = kStartSpacing_m; x <= options_.max_start_step_m; x += kStartSpacing_m) {
    const Start start{Rigid3d::Translation(x, 0.0, 0.0), false, false};
    Candidate other = EstimateFrom(frame, start, bins, period_s, executor);
    if (other.score < best.score) best = std::move(other);
  }
  const Start start{best.estimate.T_ref_body, false, true};
  return EstimateFrom(frame, start, bins, period_s, executor).estimate;
}

}  // namespace tvl
