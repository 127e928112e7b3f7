// A residual with its Jacobian with respect to a right perturbation T Exp(d), d = [rot, trans].
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

template <int N>
struct Residual {
  Eigen::Matrix<double, N, 1> r;
  Eigen::Matrix<double, N, 6> J;
};

}  // namespace tvl
