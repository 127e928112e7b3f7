#include "tvl/loop/loop_registration.h"

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/optim/pose_solver.h"

namespace tvl {
namespace {

std::vector<Eigen::Vector3f> EveryNth(const std::vector<Eigen::Vector3f>& points, int n) {
  std::vector<Eigen::Vector3f> kept;
  for (size_t i = 0; i < points.size(); i += static_cast<size_t>(n)) kept.push_back(points[i]);
  return kept;
}

struct Round {
  LaserMatches matches;
  PoseSolution solution;
};

// Matches at T within the gate, then solves.
Round RunRound(const LoopSource& source, const LoopSubmap& submap, const Rigid3d& T, double gate_m,
               const LoopRegistrationOptions& options, const Executor& executor) {
  MatchNoise noise = options.noise;
  noise.sensor_sigma_m = std::max(noise.sensor_sigma_m, options.gate_share * gate_m);
  noise.edge_sigma_m = std::max(noise.edge_sigma_m, options.gate_share * gate_m);
  Round round;
  round.matches.planes = MatchPlanes(source.planes, submap.planes(), T, gate_m, noise, executor);
  round.matches.lines = MatchLines(source.edges, submap.lines(), T, gate_m, noise);
  PoseSolverOptions solver;
  solver.max_iterations = 3;
  round.solution = SolvePose(
      T,
      [&](const Rigid3d& at) {
        return Linearize(round.matches, at, SweepBins::Compensated(), options.kernel_sigmas,
                         executor)
            .normal;
      },
      solver);
  return round;
}

}  // namespace

void LoopRegistrationOptions::Check() const {
  TVL_CHECK_INPUT(!coarse_gates_m.empty() && !fine_gates_m.empty())
      << "loop_registration.*_gates_m: at least one round each";
  for (const auto* gates : {&coarse_gates_m, &fine_gates_m}) {
    for (const double gate_m : *gates) {
      TVL_CHECK_INPUT(gate_m > 0.0) << "loop_registration.*_gates_m: must be positive";
    }
  }
  TVL_CHECK_INPUT(gate_share >= 0.0) << "loop_registration.gate_share: must not be negative";
  TVL_CHECK_INPUT(coarse_every_point >= 1) << "loop_registration.coarse_every_point: at least 1";
  TVL_CHECK_INPUT(kernel_sigmas > 0.0) << "loop_registration.kernel_sigmas: must be positive";
  weakness.Check();
  covariance.Check();
}

Rigid3d RegisterCoarsely(const LoopSource& source, const LoopSubmap& submap,
                         const Rigid3d& T_odom_current, const LoopRegistrationOptions& options,
                         const Executor& executor) {
  LoopSource thin;
  thin.planes = EveryNth(source.planes, options.coarse_every_point);
  thin.edges = EveryNth(source.edges, options.coarse_every_point);
  Rigid3d T = T_odom_current;
  for (const double gate_m : options.coarse_gates_m) {
    T = RunRound(thin, submap, T, gate_m, options, executor).solution.T;
  }
  return T;
}

LoopRegistration RegisterFinely(const LoopSource& source, const LoopSubmap& submap,
                                const Rigid3d& T_odom_current,
                                const LoopRegistrationOptions& options, const Executor& executor) {
  LoopRegistrationOptions precise = options;
  Rigid3d T = T_odom_current;
  Round round;
  for (size_t i = 0; i < options.fine_gates_m.size(); ++i) {
    if (i + 1 == options.fine_gates_m.size()) precise.gate_share = 0.0;
    round = RunRound(source, submap, T, options.fine_gates_m[i], precise, executor);
    T = round.solution.T;
  }
  const LaserSum sum =
      Linearize(round.matches, T, SweepBins::Compensated(), options.kernel_sigmas, executor);
  const Weakness weakness = AnalyseWeakness(sum, NormalEquations(), options.weakness);
  LoopRegistration result;
  result.T_odom_current = T;
  result.covariance = HonestCovariance(sum.normal.H, 0.0, options.covariance);
  result.translation_ratio = weakness.translation_ratio;
  result.rotation_ratio = weakness.rotation_ratio;
  result.matches = static_cast<int>(round.matches.planes.size() + round.matches.lines.size());
  return result;
}

}  // namespace tvl
