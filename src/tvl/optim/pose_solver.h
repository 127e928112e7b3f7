// Levenberg-Marquardt over one rigid motion, alone or with nuisance parameters beside it.
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

// A pose and six nuisance parameters ("shift": what a sensor's measurement may be off by). The
// parameters are ordered like a tangent vector: three in rad, three in m.
struct ShiftedPose {
  Rigid3d T;
  Vector6d shift = Vector6d::Zero();
};

// Gauss-Newton normal equations of a cost F(T Exp(d), shift + e) in (d, e). Parameters that are not
// in use have the unit diagonal in H_shift and zeros elsewhere.
struct ShiftedEquations {
  NormalEquations pose;  // H, b of d; the cost is that of everything
  bool has_shift = false;
  Matrix6d H_shift = Matrix6d::Identity();
  Matrix6d H_cross = Matrix6d::Zero();  // rows d, columns e
  Vector6d b_shift = Vector6d::Zero();
};

// The equations of d alone, e eliminated (Schur complement): minimised over e, the quadratic model
// of F has this H, this b and this cost.
NormalEquations WithoutShift(const ShiftedEquations& equations);

struct PoseSolution {
  Rigid3d T;
  Vector6d shift = Vector6d::Zero();
  // At the returned T and shift, with the shift eliminated; the cost is F itself.
  NormalEquations at_T;
  int iterations = 0;      // accepted steps
  bool converged = false;  // the last step was below the stop thresholds
};

// Minimises the cost that `linearize` evaluates, starting at T. `linearize` must be a pure function
// of its argument.
PoseSolution SolvePose(const Rigid3d& T,
                       const std::function<NormalEquations(const Rigid3d&)>& linearize,
                       const PoseSolverOptions& options);

// Minimises F over pose and shift together, starting at (T, 0). A step is accepted by F, so no
// accepted step raises it.
PoseSolution SolveShiftedPose(const Rigid3d& T,
                              const std::function<ShiftedEquations(const ShiftedPose&)>& linearize,
                              const PoseSolverOptions& options);

}  // namespace tvl
