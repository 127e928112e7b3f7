#include "tvl/registration/weakness.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

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

// What one judgement of both blocks collects, by column of the axes.
struct Judgement {
  Matrix6d axes = Matrix6d::Zero();
  Vector6d lambda = Vector6d::Zero(), say = Vector6d::Ones();
  std::vector<WeakDirection> directions;
};

// Judges one block; returns the smallest ratio.
double JudgeBlock(int first, const Matrix6d& H_laser, const Matrix6d& H_visual,
                  const Eigen::Matrix3d& leak, const BlockThresholds& thresholds,
                  Judgement* judgement) {
  const Solver3 eigen(MarginalBlock(H_laser, first));
  const Eigen::Matrix3d visual = MarginalBlock(H_visual, first);
  const double strongest = std::max(eigen.eigenvalues()[2], 1e-9);
  judgement->axes.block<3, 3>(first, first) = eigen.eigenvectors();
  judgement->lambda.segment<3>(first) = eigen.eigenvalues();
  double smallest = 1.0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    const double leaked = axis.dot(leak * axis);
    const double ratio = std::max(0.0, eigen.eigenvalues()[i] - leaked) / strongest;
    smallest = std::min(smallest, ratio);
    WeakDirection direction;
    direction.say = Say(ratio, thresholds);
    judgement->say[first + i] = direction.say;
    if (direction.say >= 1.0) continue;
    direction.is_rotation = first == 0;
    direction.axis_lidar = axis;
    direction.lidar_strength = ratio;
    direction.camera_strength = std::max(0.0, axis.dot(visual * axis)) / strongest;
    judgement->directions.push_back(direction);
  }
  return smallest;
}

// Information that keeps a shift finite where neither the laser nor its say bounds it: no
// measurement is off by more than a lidar's range or a turn.
constexpr double kLargestShift_rad = 6.3, kLargestShift_m = 100.0;

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
  const Eigen::Matrix3d leak = laser.plane_information * sin_sq * Eigen::Matrix3d::Identity();
  Judgement judgement;
  Weakness weakness;
  weakness.translation_ratio =
      JudgeBlock(3, laser.normal.H, visual.H, leak,
                 {options.weak_translation, options.held_translation}, &judgement);
  // On the plain the normals' noise alone would hold the yaw.
  weakness.rotation_ratio = JudgeBlock(0, laser.normal.H, visual.H, sin_sq * laser.plane_lever_m2,
                                       {options.weak_rotation, options.held_rotation}, &judgement);
  weakness.shift = MakeLaserShift(judgement.axes, judgement.lambda, judgement.say);
  weakness.directions = std::move(judgement.directions);
  return weakness;
}

LaserShift MakeLaserShift(const Matrix6d& axes, const Vector6d& lambda, const Vector6d& say) {
  LaserShift shift;
  shift.axes = axes;
  for (int i = 0; i < 6; ++i) {
    if (say[i] >= 1.0) continue;
    const double largest = i < 3 ? kLargestShift_rad : kLargestShift_m;
    shift.is_free[i] = 1.0;
    shift.information[i] =
        say[i] / (1.0 - say[i]) * std::max(0.0, lambda[i]) + 1.0 / (largest * largest);
  }
  return shift;
}

Rigid3d ShiftedByLaser(const ShiftedPose& pose, const LaserShift& shift) {
  return shift.any() ? pose.T * Rigid3d::Exp(shift.axes * pose.shift) : pose.T;
}

ShiftedEquations WithShift(const NormalEquations& laser, const ShiftedPose& pose,
                           const LaserShift& shift) {
  ShiftedEquations out;
  out.pose = laser;
  out.has_shift = shift.any();
  if (!out.has_shift) return out;
  const Vector6d xi = shift.axes * pose.shift;
  // T Exp(d) Exp(xi) = T Exp(xi) Exp(J_pose d), and Exp(xi + axes e) = Exp(xi) Exp(J_shift e).
  const Matrix6d J_pose = Rigid3d::Exp(xi).Inverse().Adjoint();
  const Matrix6d J_shift = RightJacobianSe3(xi) * shift.axes * shift.is_free.asDiagonal();
  const Vector6d unused = Vector6d::Ones() - shift.is_free;
  out.pose.H = J_pose.transpose() * laser.H * J_pose;
  out.pose.b = J_pose.transpose() * laser.b;
  out.pose.cost += 0.5 * pose.shift.dot(shift.information.asDiagonal() * pose.shift);
  out.H_cross = J_pose.transpose() * laser.H * J_shift;
  out.H_shift = J_shift.transpose() * laser.H * J_shift;
  out.H_shift.diagonal() += shift.information + unused;
  out.b_shift = J_shift.transpose() * laser.b + shift.information.asDiagonal() * pose.shift;
  return out;
}

}  // namespace tvl
