#include "tvl/registration/weakness.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

using Solver3 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;

// Information of block `first` (0 rotation, 3 translation) with the other block marginalised out.
Eigen::Matrix3d MarginalBlock(const Matrix6d& H, int first) {
  const int other = 3 - first;
  const Eigen::Matrix3d H_oo = H.block<3, 3>(other, other) + 1e-9 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d H_fo = H.block<3, 3>(first, other);
  return H.block<3, 3>(first, first) - H_fo * H_oo.ldlt().solve(H_fo.transpose());
}

struct BlockThresholds {
  double weak, held;
};

// Share of its say the lidar keeps in a direction of relative strength `ratio`.
double Say(double ratio, const BlockThresholds& thresholds) {
  return std::clamp((ratio - thresholds.weak) / (thresholds.held - thresholds.weak), 0.0, 1.0);
}

// Judges one block, adds to `weakness`; returns the smallest ratio.
double JudgeBlock(int first, const Matrix6d& H_laser, const Matrix6d& H_visual,
                  const Eigen::Vector3d& leak, const BlockThresholds& thresholds,
                  Weakness* weakness) {
  const Solver3 eigen(MarginalBlock(H_laser, first));
  const Eigen::Matrix3d visual = MarginalBlock(H_visual, first);
  const double strongest = std::max(eigen.eigenvalues()[2], 1e-9);
  double smallest = 1.0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    const double leaked = leak.dot(axis.cwiseAbs2());
    const double ratio = std::max(0.0, eigen.eigenvalues()[i] - leaked) / strongest;
    smallest = std::min(smallest, ratio);
    const double say = Say(ratio, thresholds);
    if (say >= 1.0) continue;
    weakness->lidar_mask.block<3, 3>(first, first) -= (1.0 - say) * axis * axis.transpose();
    WeakDirection direction;
    direction.is_rotation = first == 0;
    direction.axis_lidar = axis;
    direction.lidar_strength = ratio;
    direction.camera_strength = std::max(0.0, axis.dot(visual * axis)) / strongest;
    weakness->directions.push_back(direction);
  }
  return smallest;
}

}  // namespace

void WeaknessOptions::Check() const {
  TVL_CHECK_INPUT(normal_sigma_rad >= 0.0) << "weakness.normal_sigma_rad: must not be negative";
  TVL_CHECK_INPUT(weak_translation >= 0.0 && held_translation > weak_translation)
      << "weakness.weak_translation, held_translation: want 0 <= weak < held";
  TVL_CHECK_INPUT(weak_rotation >= 0.0 && held_rotation > weak_rotation)
      << "weakness.weak_rotation, held_rotation: want 0 <= weak < held";
}

Weakness AnalyseWeakness(const LaserSum& laser, const NormalEquations& visual,
                         const WeaknessOptions& options) {
  const double sin_sq = std::pow(std::sin(options.normal_sigma_rad), 2);
  const Eigen::Vector3d leak = Eigen::Vector3d::Constant(laser.plane_information * sin_sq);
  Weakness weakness;
  weakness.translation_ratio =
      JudgeBlock(3, laser.normal.H, visual.H, leak,
                 {options.weak_translation, options.held_translation}, &weakness);
  // Normals do not leak into rotation in proportion to their number: the lever arms decide, and a
  // rotation no surface holds (a sphere) does not occur outdoors.
  weakness.rotation_ratio = JudgeBlock(0, laser.normal.H, visual.H, Eigen::Vector3d::Zero(),
                                       {options.weak_rotation, options.held_rotation}, &weakness);
  return weakness;
}

NormalEquations Masked(const NormalEquations& laser, const Matrix6d& mask) {
  NormalEquations out;
  out.H = mask.transpose() * laser.H * mask;
  out.b = mask.transpose() * laser.b;
  out.cost = laser.cost;
  return out;
}

}  // namespace tvl
