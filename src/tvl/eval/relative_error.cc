#include "tvl/eval/relative_error.h"

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/eval/path_length.h"

namespace tvl {
namespace {

RelativeError RootMeanSquare(const std::vector<MotionError>& errors) {
  RelativeError result;
  result.count = errors.size();
  if (errors.empty()) return result;
  double sum_m_sq = 0.0, sum_deg_sq = 0.0;
  for (const MotionError& error : errors) {
    sum_m_sq += error.translation_m * error.translation_m;
    sum_deg_sq += error.rotation_deg * error.rotation_deg;
  }
  result.translation_rmse_m = std::sqrt(sum_m_sq / static_cast<double>(errors.size()));
  result.rotation_rmse_deg = std::sqrt(sum_deg_sq / static_cast<double>(errors.size()));
  return result;
}

}  // namespace

MotionError ErrorOfMotion(const Rigid3d& truth_a, const Rigid3d& truth_b, const Rigid3d& estimate_a,
                          const Rigid3d& estimate_b) {
  const Rigid3d error =
      (truth_a.Inverse() * truth_b).Inverse() * (estimate_a.Inverse() * estimate_b);
  return {error.t().norm(), RadToDeg(error.RotationAngle())};
}

RelativeError RelativeErrorPerFrame(const std::vector<Rigid3d>& truth,
                                    const std::vector<Rigid3d>& estimate) {
  TVL_CHECK(truth.size() == estimate.size()) << truth.size() << ", " << estimate.size();
  std::vector<MotionError> errors;
  for (size_t i = 1; i < truth.size(); ++i) {
    errors.push_back(ErrorOfMotion(truth[i - 1], truth[i], estimate[i - 1], estimate[i]));
  }
  return RootMeanSquare(errors);
}

RelativeError RelativeErrorPerDistance(const std::vector<Rigid3d>& truth,
                                       const std::vector<Rigid3d>& estimate, double distance_m) {
  TVL_CHECK(truth.size() == estimate.size()) << truth.size() << ", " << estimate.size();
  const std::vector<double> lengths_m = PathLengths(truth);
  std::vector<MotionError> errors;
  for (size_t i = 0; i < truth.size(); ++i) {
    const auto j = IndexAfter(lengths_m, i, distance_m);
    if (!j) break;
    errors.push_back(ErrorOfMotion(truth[i], truth[*j], estimate[i], estimate[*j]));
  }
  return RootMeanSquare(errors);
}

}  // namespace tvl
