#include "tvl/eval/absolute_error.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

Eigen::Vector3d MeanPosition(const std::vector<Rigid3d>& poses) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3d& pose : poses) sum += pose.t();
  return sum / static_cast<double>(poses.size());
}

}  // namespace

Rigid3d AlignPositions(const std::vector<Rigid3d>& truth, const std::vector<Rigid3d>& estimate) {
  TVL_CHECK(truth.size() == estimate.size() && !truth.empty())
      << truth.size() << ", " << estimate.size();
  const Eigen::Vector3d truth_mean = MeanPosition(truth), estimate_mean = MeanPosition(estimate);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < truth.size(); ++i) {
    covariance += (truth[i].t() - truth_mean) * (estimate[i].t() - estimate_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  // A reflection would fit better: turn the weakest axis back.
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {R, truth_mean - R * estimate_mean};
}

Rigid3d AlignFirstPose(const std::vector<Rigid3d>& truth, const std::vector<Rigid3d>& estimate) {
  TVL_CHECK(!truth.empty() && !estimate.empty());
  return truth.front() * estimate.front().Inverse();
}

std::vector<double> PositionErrors_m(const std::vector<Rigid3d>& truth,
                                     const std::vector<Rigid3d>& estimate,
                                     const Rigid3d& T_truth_estimate) {
  TVL_CHECK(truth.size() == estimate.size()) << truth.size() << ", " << estimate.size();
  std::vector<double> errors_m(truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    errors_m[i] = (truth[i].t() - T_truth_estimate * estimate[i].t()).norm();
  }
  return errors_m;
}

AbsoluteError SummariseErrors(std::vector<double> errors_m) {
  TVL_CHECK(!errors_m.empty());
  const auto n = static_cast<double>(errors_m.size());
  AbsoluteError summary;
  for (const double error : errors_m) {
    summary.mean_m += error / n;
    summary.rmse_m += error * error / n;
  }
  summary.rmse_m = std::sqrt(summary.rmse_m);
  std::sort(errors_m.begin(), errors_m.end());
  summary.median_m = errors_m[errors_m.size() / 2];
  summary.max_m = errors_m.back();
  return summary;
}

}  // namespace tvl
