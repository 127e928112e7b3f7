// Levenberg-Marquardt over one rigid motion.
#pragma once

#include <functional>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// Gauss-Newton normal equations of a robust cost: 0.5 sum rho(r^2), H ~ sum w J^T J,
// b = sum w J^T r, for a right perturbation T Exp(d): the step solves H d = -b.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0.0;

  NormalEquations& operator+=(const NormalEquations& other) {
    H += other.H;
    b += other.b;
    cost += other.cost;
    return *this;
  }
};

struct PoseSolverOptions {
  int max_iterations = 4;
  double initial_damping = 1e-6;    // relative to the diagonal: the problems are well posed
  double stop_rotation_rad = 1e-6;  // 20 um at 20 m
  double stop_translation_m = 2e-5;
};

struct PoseSolution {
  Rigid3d T;
  NormalEquations at_T;    // at the returned T
  int iterations = 0;      // accepted steps
  bool converged = false;  // the last step was below the stop thresholds
};

// Minimises the cost that `linearize` evaluates, starting at T. `linearize` must be a pure function
// of its argument.
PoseSolution SolvePose(const Rigid3d& T,
                       const std::function<NormalEquations(const Rigid3d&)>& linearize,
                       const PoseSolverOptions& options);

}  // namespace tvl
