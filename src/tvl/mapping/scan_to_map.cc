#include "tvl/mapping/scan_to_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/factors/pose_prior.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/optim/pose_solver.h"
#include "tvl/registration/surfel_matcher.h"

namespace tvl {
namespace {

// Indices of the first point of each voxel.
std::vector<uint32_t> Thin(const std::vector<Eigen::Vector3f>& points, double voxel_m) {
  VoxelHash<char> seen;
  seen.Reserve(points.size());
  std::vector<uint32_t> kept;
  for (uint32_t i = 0; i < points.size(); ++i) {
    char& taken = seen[VoxelKey::Of(points[i].cast<double>(), voxel_m)];
    if (taken != 0) continue;
    taken = 1;
    kept.push_back(i);
  }
  return kept;
}

NormalEquations PriorTerm(const PosePrior& prior, double share, const Rigid3d& T) {
  const Residual<6> residual = EvaluatePosePrior(prior.T_world_lidar, T);
  const Matrix6d information = share * prior.covariance.ldlt().solve(Matrix6d::Identity());
  NormalEquations n;
  n.H = residual.J.transpose() * information * residual.J;
  n.b = residual.J.transpose() * information * residual.r;
  n.cost = 0.5 * residual.r.dot(information * residual.r);
  return n;
}

// One set of correspondences and everything the solver needs to weigh them.
struct Problem {
  LaserMatches laser;
  VisualMatches visual;
  Weakness weakness;
};

// What there is to match with what.
struct Sources {
  const MapStepPoints& points;
  const LocalMap& map;
  const LandmarkMap& landmarks;
  const FeatureTracks& tracks;
};

EstimateEvidence Evidence(const Problem& problem, const LaserSum& laser, const VisualSum& visual) {
  const auto rms = [](double sum, size_t n) {
    return n == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(n));
  };
  EstimateEvidence evidence;
  evidence.planes = static_cast<int>(problem.laser.planes.size());
  evidence.edges = static_cast<int>(problem.laser.lines.size());
  evidence.visual = static_cast<int>(problem.visual.size());
  evidence.plane_rms_m = rms(laser.plane_sq_m2, problem.laser.planes.size());
  evidence.edge_rms_m = rms(laser.line_sq_m2, problem.laser.lines.size());
  evidence.visual_rms = rms(visual.squared, static_cast<size_t>(visual.count));
  return evidence;
}

double MedianDistance_m(const std::vector<PlaneMatch>& planes, const Rigid3d& T, double gate_m) {
  const Eigen::Matrix3d R = T.R();
  std::vector<double> distances;
  distances.reserve(planes.size());
  for (const PlaneMatch& match : planes) {
    const double distance_m = std::abs(Evaluate(match.factor, R, T.t()).r[0]);
    if (distance_m < gate_m) distances.push_back(distance_m);
  }
  if (distances.empty()) return 0.0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

class Refiner {
 public:
  Refiner(const Rigid3d& T_cam_lidar, const PosePrior& prior, const ScanToMapOptions& options,
          const Executor& executor)
      : T_cam_lidar_(T_cam_lidar),
        prior_(prior),
        options_(options),
        noise_{options.sensor_sigma_m, options.beam_sigma_rad, options.edge_sigma_m},
        executor_(executor) {}

  LaserSum Laser(const Problem& problem, const Rigid3d& T) const {
    return Linearize(problem.laser, T, SweepBins::Compensated(), options_.kernel_sigmas, executor_);
  }
  VisualSum Visual(const Problem& problem, const Rigid3d& T) const {
    return Linearize(problem.visual, T, T_cam_lidar_, options_.visual_kernel_sigmas);
  }
  NormalEquations WithoutCamera(const Problem& problem, const Rigid3d& T) const {
    NormalEquations sum = Masked(Laser(problem, T).normal, problem.weakness.lidar_mask);
    sum += PriorTerm(prior_, options_.prior_share, T);
    return sum;
  }
  NormalEquations All(const Problem& problem, const Rigid3d& T) const {
    NormalEquations sum = WithoutCamera(problem, T);
    sum += Visual(problem, T).normal;
    return sum;
  }
  // Correspondences at T, the lidar's weak directions, and the landmarks that agree.
  Problem Match(const Sources& sources, const Rigid3d& T, double gate_m) const {
    Problem problem;
    problem.laser.planes =
        MatchPlanes(sources.points.planes, sources.map.planes(), T, gate_m, noise_, executor_);
    problem.laser.lines = MatchLines(sources.points.edges, sources.map.lines(), T, gate_m, noise_);
    if (options_.use_camera) problem.visual.forward = sources.landmarks.Match(sources.tracks, T);
    problem.weakness =
        AnalyseWeakness(Laser(problem, T), Visual(problem, T).normal, options_.weakness);
    if (options_.use_camera) problem.visual = GateVisual(problem, T);
    return problem;
  }
  bool IsSmall(const Vector6d& step) const {
    return step.head<3>().norm() < options_.stop_rotation_rad &&
           step.tail<3>().norm() < options_.stop_translation_m;
  }
  ScanToMapResult Describe(const Problem& problem, const Rigid3d& T) const {
    ScanToMapResult result;
    result.estimate.T_ref_body = T;
    result.estimate.weak = problem.weakness.directions;
    result.estimate.evidence = Evidence(problem, Laser(problem, T), Visual(problem, T));
    result.estimate.covariance =
        HonestCovariance(All(problem, T).H, prior_.step_m, options_.covariance);
    result.translation_ratio = problem.weakness.translation_ratio;
    result.rotation_ratio = problem.weakness.rotation_ratio;
    result.plane_median_m = MedianDistance_m(problem.laser.planes, T, options_.last_gate_m);
    result.planes = problem.laser.planes;
    return result;
  }

  PoseSolution Solve(const Problem& problem, const Rigid3d& T) const {
    PoseSolverOptions solver;
    solver.max_iterations = 3;
    return SolvePose(
        T, [&](const Rigid3d& candidate) { return All(problem, candidate); }, solver);
  }

 private:
  // The landmarks that agree with what laser and prior say near T.
  VisualMatches GateVisual(const Problem& problem, const Rigid3d& T) const {
    PoseSolverOptions solver;
    solver.max_iterations = 2;
    const PoseSolution alone = SolvePose(
        T, [&](const Rigid3d& at) { return WithoutCamera(problem, at); }, solver);
    CovarianceOptions wide = options_.covariance;
    wide.inflation = options_.gate_inflation;
    const Matrix6d covariance = HonestCovariance(alone.at_T.H, prior_.step_m, wide);
    return Gate(problem.visual, alone.T, T_cam_lidar_, covariance, options_.visual_gate_sigmas);
  }

  const Rigid3d& T_cam_lidar_;
  const PosePrior& prior_;
  const ScanToMapOptions& options_;
  MatchNoise noise_;
  const Executor& executor_;
};

}  // namespace

void ScanToMapOptions::Check() const {
  TVL_CHECK_INPUT(source_voxel_m > 0.0) << "mapping.source_voxel_m: must be positive";
  TVL_CHECK_INPUT(sensor_sigma_m > 0.0) << "mapping.sensor_sigma_m: must be positive";
  TVL_CHECK_INPUT(edge_sigma_m > 0.0) << "mapping.edge_sigma_m: must be positive";
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
  thin.plane_index = Thin(planes, voxel_m);
  for (const uint32_t i : thin.plane_index) thin.planes.push_back(planes[i]);
  for (const uint32_t i : Thin(edges, 0.5 * voxel_m)) thin.edges.push_back(edges[i]);
  return thin;
}

ScanToMapResult RefinePose(const MapStepPoints& points, const LocalMap& map,
                           const LandmarkMap& landmarks, const FeatureTracks& tracks,
                           const Rigid3d& T_cam_lidar, const PosePrior& prior,
                           const ScanToMapOptions& options, const Executor& executor) {
  const Refiner refiner(T_cam_lidar, prior, options, executor);
  const Sources sources{points, map, landmarks, tracks};
  Problem problem;
  Rigid3d T = prior.T_world_lidar;
  EstimateStatus status = EstimateStatus::kNotConverged;
  double gate_m = options.first_gate_m;
  int refreshes = 0;
  while (refreshes < options.max_refreshes && status != EstimateStatus::kConverged) {
    problem = refiner.Match(sources, T, gate_m);
    const PoseSolution solution = refiner.Solve(problem, T);
    if (refiner.IsSmall((T.Inverse() * solution.T).Log())) status = EstimateStatus::kConverged;
    T = solution.T;
    gate_m = std::max(options.last_gate_m, 0.5 * gate_m);
    ++refreshes;
  }
  ScanToMapResult result = refiner.Describe(problem, T);
  result.estimate.status = status;
  result.estimate.evidence.iterations = refreshes;
  const EstimateEvidence& evidence = result.estimate.evidence;
  if (evidence.planes + evidence.edges + evidence.visual < options.min_matches) {
    result.estimate.status = EstimateStatus::kPredicted;
    result.estimate.T_ref_body = prior.T_world_lidar;
    result.estimate.covariance = prior.covariance;
  }
  return result;
}

}  // namespace tvl
