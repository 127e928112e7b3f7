// Central differences over a right perturbation, for tests of analytic Jacobians.
#pragma once

#include <functional>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// d f(T Exp(d)) / d d at d = 0; f returns a column vector. Step 1e-6 rad / m.
template <typename F>
auto NumericJacobian(const F& f, const Rigid3d& T) {
  constexpr double kStep = 1e-6;
  using Residual = decltype(f(T));
  Eigen::Matrix<double, Residual::RowsAtCompileTime, 6> J;
  for (int i = 0; i < 6; ++i) {
    Vector6d d = Vector6d::Zero();
    d[i] = kStep;
    J.col(i) = (f(T * Rigid3d::Exp(d)) - f(T * Rigid3d::Exp(-d))) / (2.0 * kStep);
  }
  return J;
}

}  // namespace tvl
