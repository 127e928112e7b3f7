#include "tvl/odometry/visual_lidar_odometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {

namespace {

// Laser features that a frame offers to the odometry.
size_t Offered(const PreprocessedFrame& frame) {
  return frame.features.flat.size() + frame.features.sharp.size();
}

// Robust cost a feature, those without a match at a fixed price: to choose among starts.
double Score(const PreprocessedFrame& frame, const PoseProblem& problem, double cost) {
  constexpr double kUnmatchedCost = 3.0;  // as a residual of about 3 sigma under the kernel
  const double features = static_cast<double>(Offered(frame) + problem.visual().size());
  const double matched = static_cast<double>(problem.size());
  return (cost + kUnmatchedCost * std::max(0.0, features - matched)) / std::max(1.0, features);
}

EstimateEvidence EvidenceOf(const PreprocessedFrame& frame, const PoseProblem& problem,
                            const Rigid3d& T) {
  EstimateEvidence evidence = problem.Evidence(T);
  evidence.match_share = static_cast<double>(evidence.planes + evidence.edges) /
                         static_cast<double>(std::max<size_t>(1, Offered(frame)));
  return evidence;
}

}  // namespace

struct VisualLidarOdometry::Candidate {
  MotionEstimate estimate;
  double score = 0.0;  // see Score
};

void OdometryOptions::Check() const {
  laser.Check();
  visual.Check();
  road.Check();
  weakness.Check();
  covariance.Check();
  TVL_CHECK_INPUT(kernel_sigmas > 0.0) << "odometry.kernel_sigmas: must be positive";
  TVL_CHECK_INPUT(max_refreshes >= 1) << "odometry.max_refreshes: must be at least 1";
  TVL_CHECK_INPUT(first_gate_m >= last_gate_m && last_gate_m > 0.0)
      << "odometry.first_gate_m, last_gate_m: want first >= last > 0";
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

std::optional<RoadMotion> VisualLidarOdometry::MeasureRoad(const PreprocessedFrame& frame,
                                                           const RoadGuess& guess) const {
  if (!options_.use_camera) return std::nullopt;
  return MeasureRoadMotion(previous_visual_, {frame.tracks, frame.depths}, calibration_, guess,
                           options_.road);
}

void VisualLidarOdometry::Reset() {
  matcher_.reset();
  previous_visual_ = {};
}

PoseProblem VisualLidarOdometry::MakeProblem(const MotionGuess& guess, const SweepBins& bins,
                                             const Executor& executor) const {
  PoseProblemSetup setup;
  setup.extrinsics = {calibration_.T_cam_lidar, calibration_.rotation_covariance};
  setup.bins = bins;
  if (guess.known) setup.prior = PriorTerm::Of(guess.T_prev_cur, guess.covariance);
  setup.kernel_sigmas = options_.kernel_sigmas;
  setup.visual_kernel_sigmas = options_.visual_kernel_sigmas;
  setup.visual_gate_sigmas = options_.visual_gate_sigmas;
  setup.weakness = options_.weakness;
  setup.covariance = options_.covariance;
  setup.gate_covariance = options_.covariance;
  return {setup, executor};
}

void VisualLidarOdometry::Match(const PreprocessedFrame& frame, bool use_camera,
                                const Rigid3d& T_prev_cur, double gate_m, const SweepBins& bins,
                                double period_s, PoseProblem* problem) {
  LaserMatches laser;
  VisualMatches visual;
  if (matcher_ != nullptr && frame.has_scan) {
    const SweepFeatures features = PrepareSweep(frame.features, bins, period_s, T_prev_cur);
    laser = matcher_->Match(features, bins, T_prev_cur, gate_m, options_.laser);
  }
  if (options_.use_camera && use_camera) {
    visual = MatchVisual(previous_visual_, {frame.tracks, frame.depths}, calibration_, T_prev_cur,
                         options_.visual);
  }
  problem->SetMatches(std::move(laser), std::move(visual), T_prev_cur);
}

VisualLidarOdometry::Candidate VisualLidarOdometry::EstimateFrom(const PreprocessedFrame& frame,
                                                                 const MotionGuess& guess,
                                                                 const SweepBins& bins,
                                                                 double period_s,
                                                                 const Executor& executor) {
  PoseProblem problem = MakeProblem(guess, bins, executor);
  PoseSolution solution;
  solution.T = guess.T_prev_cur;
  Candidate candidate;
  MotionEstimate& estimate = candidate.estimate;
  estimate.status = EstimateStatus::kNotConverged;
  double gate_m = options_.first_gate_m * (guess.known ? 1.0 : 2.0);
  int refreshes = 0;
  while (refreshes < options_.max_refreshes && estimate.status != EstimateStatus::kConverged) {
    const Rigid3d T = solution.T;
    Match(frame, guess.use_camera, T, gate_m, bins, period_s, &problem);
    if (problem.size() < static_cast<size_t>(options_.min_matches)) {
      estimate.status = EstimateStatus::kPredicted;
      estimate.T_ref_body = guess.T_prev_cur;
      estimate.covariance = problem.CovarianceAt(guess.T_prev_cur);
      candidate.score = std::numeric_limits<double>::max();
      return candidate;
    }
    solution = problem.Solve(T);
    const Vector6d step = (T.Inverse() * solution.T).Log();
    if (step.head<3>().norm() < options_.stop_rotation_rad &&
        step.tail<3>().norm() < options_.stop_translation_m) {
      estimate.status = EstimateStatus::kConverged;
    }
    candidate.score = Score(frame, problem, solution.at_T.cost);
    gate_m = std::max(options_.last_gate_m, 0.5 * gate_m);
    ++refreshes;
  }
  estimate.T_ref_body = solution.T;
  estimate.covariance = problem.Covariance(solution);
  estimate.weak = problem.weakness().directions;
  estimate.evidence = EvidenceOf(frame, problem, solution.T);
  estimate.evidence.iterations = refreshes;
  return candidate;
}

MotionEstimate VisualLidarOdometry::Estimate(const PreprocessedFrame& frame,
                                             const MotionGuess& guess, const SweepBins& bins,
                                             double period_s, const Executor& executor) {
  if (guess.known) return EstimateFrom(frame, guess, bins, period_s, executor).estimate;
  // Laser alone first: without a known motion nothing tells features on moving cars from others.
  constexpr double kStartSpacing_m = 0.75;  // half of the first gate
  MotionGuess start;
  start.use_camera = false;
  Candidate best = EstimateFrom(frame, start, bins, period_s, executor);
  for (double x = kStartSpacing_m; x <= options_.max_start_step_m; x += kStartSpacing_m) {
    start.T_prev_cur = Rigid3d::Translation(x, 0.0, 0.0);
    Candidate other = EstimateFrom(frame, start, bins, period_s, executor);
    if (other.score < best.score) best = std::move(other);
  }
  start.T_prev_cur = best.estimate.T_ref_body;
  start.use_camera = guess.use_camera;
  return EstimateFrom(frame, start, bins, period_s, executor).estimate;
}

}  // namespace tvl
