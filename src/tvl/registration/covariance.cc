#include "tvl/registration/covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Directions nothing holds get this standard deviation (rad, m) at the most.
constexpr double kUnknownSigma = 10.0;

}  // namespace

void CovarianceOptions::Check() const {
  TVL_CHECK_INPUT(inflation >= 1.0) << "covariance.inflation: must be at least 1";
  TVL_CHECK_INPUT(floor_translation >= 0.0 && floor_rotation_rad_per_m >= 0.0)
      << "covariance.floor_*: must not be negative";
}

Matrix6d HonestCovariance(const Matrix6d& H, double length_m, const CovarianceOptions& options,
                          const Matrix6d& prior) {
  const Matrix6d regular =
      H / options.inflation + prior + Matrix6d::Identity() / (kUnknownSigma * kUnknownSigma);
  Matrix6d covariance = regular.ldlt().solve(Matrix6d::Identity());
  const double rotation_rad =
      std::max(options.floor_rotation_rad, options.floor_rotation_rad_per_m * length_m);
  const double translation_m =
      std::max(options.floor_translation_m, options.floor_translation * length_m);
  covariance.diagonal().head<3>().array() += rotation_rad * rotation_rad;
  covariance.diagonal().tail<3>().array() += translation_m * translation_m;
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace tvl
