#include "tvl/optim/pose_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace tvl {
namespace {

struct Step {
  Vector6d pose = Vector6d::Zero(), shift = Vector6d::Zero();
};

Vector6d DampedPoseStep(const Matrix6d& H, const Vector6d& b, const Vector6d& diagonal,
                        double damping) {
  Matrix6d damped = H;
  // A tiny absolute floor keeps unobserved directions at rest instead of undefined.
  damped.diagonal() += damping * diagonal + Vector6d::Constant(1e-9);
  return -damped.ldlt().solve(b);
}

// Only damping beyond `initial_damping` holds the shift back: damping both alike would split an
// offset that either may take, and the pose is to stay where only the shift is asked for.
Step DampedStep(const ShiftedEquations& n, double damping, double initial_damping) {
  const Vector6d diagonal = n.pose.H.diagonal();
  if (!n.has_shift) return {DampedPoseStep(n.pose.H, n.pose.b, diagonal, damping)};
  ShiftedEquations damped = n;
  damped.H_shift.diagonal() *= 1.0 + (damping - initial_damping);
  const NormalEquations reduced = WithoutShift(damped);
  Step step;
  step.pose = DampedPoseStep(reduced.H, reduced.b, diagonal, damping);
  step.shift = -damped.H_shift.ldlt().solve(n.b_shift + n.H_cross.transpose() * step.pose);
  return step;
}

bool IsSmall(const Vector6d& step, const PoseSolverOptions& options) {
  return step.head<3>().norm() < options.stop_rotation_rad &&
         step.tail<3>().norm() < options.stop_translation_m;
}

bool IsSmall(const Step& step, const PoseSolverOptions& options) {
  return IsSmall(step.pose, options) && IsSmall(step.shift, options);
}

}  // namespace

NormalEquations WithoutShift(const ShiftedEquations& equations) {
  NormalEquations out = equations.pose;
  if (!equations.has_shift) return out;
  const Eigen::LDLT<Matrix6d> ldlt(equations.H_shift);
  const Matrix6d taken = equations.H_cross * ldlt.solve(equations.H_cross.transpose());
  const Vector6d y = ldlt.solve(equations.b_shift);
  out.H -= 0.5 * (taken + taken.transpose());
  out.b -= equations.H_cross * y;
  out.cost -= 0.5 * equations.b_shift.dot(y);
  return out;
}

PoseSolution SolveShiftedPose(const Rigid3d& T,
                              const std::function<ShiftedEquations(const ShiftedPose&)>& linearize,
                              const PoseSolverOptions& options) {
  constexpr double kMaxDamping = 1e4;
  PoseSolution solution;
  ShiftedPose pose{T, Vector6d::Zero()};
  ShiftedEquations at_pose = linearize(pose);
  double damping = options.initial_damping;
  for (int i = 0; i < options.max_iterations && damping < kMaxDamping; ++i) {
    const Step step = DampedStep(at_pose, damping, options.initial_damping);
    const ShiftedPose candidate{pose.T * Rigid3d::Exp(step.pose), pose.shift + step.shift};
    const ShiftedEquations at_candidate = linearize(candidate);
    if (at_candidate.pose.cost > at_pose.pose.cost) {
      if (IsSmall(step, options)) {  // at the bottom, to rounding
        solution.converged = true;
        break;
      }
      damping = damping < 1e-3 ? 1e-3 : 10.0 * damping;
      continue;
    }
    pose = candidate;
    at_pose = at_candidate;
    ++solution.iterations;
    damping = std::max(options.initial_damping, 0.1 * damping);
    if (IsSmall(step, options)) {
      solution.converged = true;
      break;
    }
  }
  solution.T = pose.T;
  solution.shift = pose.shift;
  solution.at_T = WithoutShift(at_pose);
  solution.at_T.cost = at_pose.pose.cost;
  return solution;
}

PoseSolution SolvePose(const Rigid3d& T,
                       const std::function<NormalEquations(const Rigid3d&)>& linearize,
                       const PoseSolverOptions& options) {
  const auto without_shift = [&](const ShiftedPose& pose) {
    ShiftedEquations equations;
    equations.pose = linearize(pose.T);
    return equations;
  };
  return SolveShiftedPose(T, without_shift, options);
}

}  // namespace tvl
