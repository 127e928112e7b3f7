#include "tvl/registration/surfel.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr double kScale = 1024.0;  // integer units a metre

Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> Decompose(const PointMoments& moments) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.Covariance_m2());
  return solver;
}

Surfel Describe(const PointMoments& moments, const Eigen::Vector3d& centre_m) {
  Surfel surfel;
  surfel.count = static_cast<double>(moments.count);
  surfel.mean = centre_m + moments.MeanCentred_m();
  return surfel;
}

}  // namespace

void SurfelOptions::Check() const {
  TVL_CHECK_INPUT(min_points >= 3) << "surfel.min_points: must be at least 3";
  TVL_CHECK_INPUT(max_thickness_m > 0.0) << "surfel.max_thickness_m: must be positive";
  TVL_CHECK_INPUT(min_shape_ratio >= 1.0) << "surfel.min_shape_ratio: must be at least 1";
  TVL_CHECK_INPUT(min_extent_share >= 0.0) << "surfel.min_extent_share: must not be negative";
}

void PointMoments::Add(const Eigen::Vector3d& p_centred_m, int sign) {
  const int64_t x = std::llround(p_centred_m.x() * kScale);
  const int64_t y = std::llround(p_centred_m.y() * kScale);
  const int64_t z = std::llround(p_centred_m.z() * kScale);
  count += sign;
  sum[0] += sign * x;
  sum[1] += sign * y;
  sum[2] += sign * z;
  square[0] += sign * x * x;
  square[1] += sign * x * y;
  square[2] += sign * x * z;
  square[3] += sign * y * y;
  square[4] += sign * y * z;
  square[5] += sign * z * z;
}

Eigen::Vector3d PointMoments::MeanCentred_m() const {
  const double scale = 1.0 / (kScale * static_cast<double>(count));
  return scale * Eigen::Vector3d(static_cast<double>(sum[0]), static_cast<double>(sum[1]),
                                 static_cast<double>(sum[2]));
}

Eigen::Matrix3d PointMoments::Covariance_m2() const {
  const double scale = 1.0 / (kScale * kScale * static_cast<double>(count));
  const Eigen::Vector3d mean = MeanCentred_m();
  Eigen::Matrix3d second;
  const auto at = [&](int i) { return scale * static_cast<double>(square[i]); };
  second << at(0), at(1), at(2), at(1), at(3), at(4), at(2), at(4), at(5);
  return second - mean * mean.transpose();
}

Surfel FitPlane(const PointMoments& moments, const Eigen::Vector3d& centre_m, double size_m,
                const SurfelOptions& options) {
  if (moments.count < options.min_points) return {};
  const auto eigen = Decompose(moments);
  const Eigen::Vector3d variance = eigen.eigenvalues().cwiseMax(0.0);
  Surfel surfel = Describe(moments, centre_m);
  surfel.axis = eigen.eigenvectors().col(0);
  surfel.thickness_sq_m2 = variance[0];
  surfel.extent_sq_m2 = variance[1];
  const double ratio_sq = options.min_shape_ratio * options.min_shape_ratio;
  const double min_extent_m = options.min_extent_share * size_m;
  const bool is_plane = variance[0] < options.max_thickness_m * options.max_thickness_m &&
                        variance[1] > ratio_sq * variance[0] &&
                        variance[1] > min_extent_m * min_extent_m;
  surfel.kind = is_plane ? SurfelKind::kPlane : SurfelKind::kNone;
  return surfel;
}

Surfel FitLine(const PointMoments& moments, const Eigen::Vector3d& centre_m, double size_m,
               const SurfelOptions& options) {
  if (moments.count < options.min_points) return {};
  const auto eigen = Decompose(moments);
  const Eigen::Vector3d variance = eigen.eigenvalues().cwiseMax(0.0);
  Surfel surfel = Describe(moments, centre_m);
  surfel.axis = eigen.eigenvectors().col(2);
  surfel.thickness_sq_m2 = variance[1];
  surfel.extent_sq_m2 = variance[2];
  const double ratio_sq = options.min_shape_ratio * options.min_shape_ratio;
  const double min_extent_m = options.min_extent_share * size_m;
  const bool is_line = variance[1] < options.max_thickness_m * options.max_thickness_m &&
                       variance[2] > ratio_sq * variance[1] &&
                       variance[2] > min_extent_m * min_extent_m;
  surfel.kind = is_line ? SurfelKind::kLine : SurfelKind::kNone;
  return surfel;
}

}  // namespace tvl
