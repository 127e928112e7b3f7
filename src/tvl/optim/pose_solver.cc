#include "tvl/optim/pose_solver.h"

#include <Eigen/Cholesky>

namespace tvl {
namespace {

Vector6d DampedStep(const NormalEquations& n, double damping) {
  Matrix6d H = n.H;
  // A tiny absolute floor keeps unobserved directions at rest instead of undefined.
  H.diagonal() += damping * n.H.diagonal() + Vector6d::Constant(1e-9);
  return -H.ldlt().solve(n.b);
}

bool IsSmall(const Vector6d& step, const PoseSolverOptions& options) {
  return step.head<3>().norm() < options.stop_rotation_rad &&
         step.tail<3>().norm() < options.stop_translation_m;
}

}  // namespace

PoseSolution SolvePose(const Rigid3d& T,
                       const std::function<NormalEquations(const Rigid3d&)>& linearize,
                       const PoseSolverOptions& options) {
  constexpr double kMaxDamping = 1e4;
  PoseSolution solution;
  solution.T = T;
  solution.at_T = linearize(T);
  double damping = options.initial_damping;
  for (int i = 0; i < options.max_iterations && damping < kMaxDamping; ++i) {
    const Vector6d step = DampedStep(solution.at_T, damping);
    const Rigid3d candidate = solution.T * Rigid3d::Exp(step);
    const NormalEquations at_candidate = linearize(candidate);
    if (at_candidate.cost > solution.at_T.cost) {
      if (IsSmall(step, options)) {  // at the bottom, to rounding
        solution.converged = true;
        break;
      }
      damping = damping < 1e-3 ? 1e-3 : 10.0 * damping;
      continue;
    }
    solution.T = candidate;
    solution.at_T = at_candidate;
    ++solution.iterations;
    damping = std::max(options.initial_damping, 0.1 * damping);
    if (IsSmall(step, options)) {
      solution.converged = true;
      break;
    }
  }
  return solution;
}

}  // namespace tvl
