// Robust kernels: rho(r^2) with r a whitened residual (unit variance), cost = sum 0.5 rho.
#pragma once

#include <cmath>

namespace tvl {

struct RobustValue {
  double rho;     // robust squared residual
  double weight;  // d rho / d r^2: the weight of iteratively reweighted least squares
};

// Quadratic inside k, linear outside.
inline RobustValue Huber(double r_sq, double k) {
  if (r_sq <= k * k) return {r_sq, 1.0};
  const double r = std::sqrt(r_sq);
  return {2.0 * k * r - k * k, k / r};
}

// Grows with the logarithm: for residuals among which there are true outliers.
inline RobustValue Cauchy(double r_sq, double k) {
  const double s = 1.0 + r_sq / (k * k);
  return {k * k * std::log(s), 1.0 / s};
}

}  // namespace tvl
