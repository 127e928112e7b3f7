#include "tvl/mapping/scan_to_map.h"

#include <algorithm>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/geometry/voxel_thinning.h"
#include "tvl/registration/surfel_matcher.h"

namespace tvl {
namespace {

// What there is to match with what.
struct Sources {
  const MapStepPoints& points;
  const LocalMap& map;
  const LandmarkMap& landmarks;
  const FeatureTracks& tracks;
};

// Distances of the matched points to their planes, or lines, at T, of those within the gate, m.
template <typename Match>
std::vector<double> DistancesWithin_m(const std::vector<Match>& matches, const Rigid3d& T,
                                      double gate_m) {
  const Eigen::Matrix3d R = T.R();
  std::vector<double> distances_m;
  distances_m.reserve(matches.size());
  for (const Match& match : matches) {
    const double distance_m = Evaluate(match.factor, R, T.t()).r.norm();
    if (distance_m < gate_m) distances_m.push_back(distance_m);
  }
  return distances_m;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

PoseProblemSetup SetupOf(const Sources& sources, const Calibration& calibration,
                         const PosePrior& prior, const ScanToMapOptions& options) {
  PoseProblemSetup setup;
  setup.extrinsics = {calibration.T_cam_lidar, calibration.rotation_covariance};
  if (options.use_camera) {
    setup.T_ref_seen =
        Rigid3d(prior.T_world_lidar.q(),
                sources.landmarks.MeanAnchor_m(sources.tracks, prior.T_world_lidar.t()));
  }
  setup.bins = SweepBins::Compensated();
  setup.prior = PriorTerm::Of(prior.T_world_lidar, prior.covariance, options.prior_share);
  setup.kernel_sigmas = options.kernel_sigmas;
  setup.beam_sigma_rad = options.common_beam_sigma_rad;
  setup.visual_kernel_sigmas = options.visual_kernel_sigmas;
  setup.visual_gate_sigmas = options.visual_gate_sigmas;
  setup.weakness = options.weakness;
  setup.covariance = options.covariance;
  setup.gate_covariance = options.covariance;
  setup.gate_covariance.inflation = options.gate_inflation;
  setup.step_m = prior.step_m;
  return setup;
}

// Correspondences at T.
void Match(const Sources& sources, const Rigid3d& T, double gate_m, const ScanToMapOptions& options,
           const Executor& executor, PoseProblem* problem) {
  const MatchNoise noise{options.sensor_sigma_m, options.beam_sigma_rad, options.edge_sigma_m};
  LaserMatches laser;
  VisualMatches visual;
  laser.planes =
      MatchPlanes(sources.points.planes, sources.map.planes(), T, gate_m, noise, executor);
  if (!sources.points.plane_beam.empty()) {
    for (PlaneMatch& match : laser.planes) match.beam = sources.points.plane_beam[match.source];
  }
  laser.lines = MatchLines(sources.points.edges, sources.map.lines(), T, gate_m, noise);
  if (options.use_camera) visual.forward = sources.landmarks.Match(sources.tracks, T);
  problem->SetMatches(std::move(laser), std::move(visual), T);
}

bool IsSmall(const Vector6d& step, const ScanToMapOptions& options) {
  return step.head<3>().norm() < options.stop_rotation_rad &&
         step.tail<3>().norm() < options.stop_translation_m;
}

ScanToMapResult Describe(const PoseProblem& problem, const PoseSolution& solution,
                         const MapStepPoints& points, const ScanToMapOptions& options) {
  ScanToMapResult result;
  MotionEstimate& estimate = result.estimate;
  estimate.T_ref_body = solution.T;
  estimate.covariance = problem.Covariance(solution);
  estimate.information = problem.Information(solution);
  estimate.weak = problem.weakness().directions;
  estimate.evidence = problem.Evidence(solution.T);
  const std::vector<double> planes_m =
      DistancesWithin_m(problem.laser().planes, solution.T, options.last_gate_m);
  const size_t lines =
      DistancesWithin_m(problem.laser().lines, solution.T, options.last_gate_m).size();
  const size_t offered = std::max<size_t>(1, points.planes.size() + points.edges.size());
  estimate.evidence.match_share =
      static_cast<double>(planes_m.size() + lines) / static_cast<double>(offered);
  result.translation_ratio = problem.weakness().translation_ratio;
  result.rotation_ratio = problem.weakness().rotation_ratio;
  result.plane_median_m = Median(planes_m);
  result.planes = problem.laser().planes;
  return result;
}

}  // namespace

void ScanToMapOptions::Check() const {
  TVL_CHECK_INPUT(source_voxel_m > 0.0) << "mapping.source_voxel_m: must be positive";
  TVL_CHECK_INPUT(sensor_sigma_m > 0.0) << "mapping.sensor_sigma_m: must be positive";
  TVL_CHECK_INPUT(edge_sigma_m > 0.0) << "mapping.edge_sigma_m: must be positive";
  TVL_CHECK_INPUT(common_beam_sigma_rad >= 0.0)
      << "mapping.common_beam_sigma_deg: must not be negative";
  TVL_CHECK_INPUT(kernel_sigmas > 0.0) << "mapping.kernel_sigmas: must be positive";
  TVL_CHECK_INPUT(max_refreshes >= 1) << "mapping.max_refreshes: must be at least 1";
  TVL_CHECK_INPUT(first_gate_m >= last_gate_m && last_gate_m > 0.0)
      << "mapping.first_gate_m, last_gate_m: want first >= last > 0";
  TVL_CHECK_INPUT(prior_share >= 0.0 && prior_share <= 1.0)
      << "mapping.prior_share: must be in 0..1";
  TVL_CHECK_INPUT(gate_inflation >= 1.0) << "mapping.gate_inflation: must be at least 1";
  weakness.Check();
  covariance.Check();
}

MapStepPoints ThinForMapStep(const std::vector<Eigen::Vector3f>& planes,
                             const std::vector<Eigen::Vector3f>& edges, double voxel_m) {
  MapStepPoints thin;
  thin.plane_index = MiddleOfEachVoxel(planes, voxel_m);
  for (const uint32_t i : thin.plane_index) thin.planes.push_back(planes[i]);
  for (const uint32_t i : MiddleOfEachVoxel(edges, 0.5 * voxel_m)) thin.edges.push_back(edges[i]);
  return thin;
}

ScanToMapResult RefinePose(const MapStepPoints& points, const LocalMap& map,
                           const LandmarkMap& landmarks, const FeatureTracks& tracks,
                           const Calibration& calibration, const PosePrior& prior,
                           const ScanToMapOptions& options, const Executor& executor) {
  const Sources sources{points, map, landmarks, tracks};
  PoseProblem problem(SetupOf(sources, calibration, prior, options), executor);
  PoseSolution solution;
  solution.T = prior.T_world_lidar;
  EstimateStatus status = EstimateStatus::kNotConverged;
  double gate_m = options.first_gate_m;
  int refreshes = 0;
  while (refreshes < options.max_refreshes && status != EstimateStatus::kConverged) {
    const Rigid3d T = solution.T;
    Match(sources, T, gate_m, options, executor, &problem);
    solution = problem.Solve(T);
    if (IsSmall((T.Inverse() * solution.T).Log(), options)) status = EstimateStatus::kConverged;
    gate_m = std::max(options.last_gate_m, 0.5 * gate_m);
    ++refreshes;
  }
  ScanToMapResult result = Describe(problem, solution, points, options);
  result.estimate.status = status;
  result.estimate.evidence.iterations = refreshes;
  if (problem.size() < static_cast<size_t>(std::max(0, options.min_matches))) {
    result.estimate.status = EstimateStatus::kPredicted;
    result.estimate.T_ref_body = prior.T_world_lidar;
    result.estimate.covariance = prior.covariance;
    result.estimate.information.setZero();
  }
  return result;
}

}  // namespace tvl
