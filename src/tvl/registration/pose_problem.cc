#include "tvl/registration/pose_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "tvl/factors/pose_prior.h"

namespace tvl {
namespace {

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  return a.t() == b.t() && a.q().coeffs() == b.q().coeffs();
}

double Rms(double sum_of_squares, size_t n) {
  return n == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(n));
}

}  // namespace

PriorTerm PriorTerm::Of(const Rigid3d& T, const Matrix6d& covariance, double share) {
  return {T, share * covariance.ldlt().solve(Matrix6d::Identity()), share};
}

PriorTerm WholeAlongWeak(const PriorTerm& prior, const std::vector<WeakDirection>& weak) {
  PriorTerm whole = prior;
  if (prior.share <= 0.0 || prior.share >= 1.0 || weak.empty()) return whole;
  const Matrix6d covariance = (prior.information / prior.share).ldlt().solve(Matrix6d::Identity());
  const auto count = static_cast<Eigen::Index>(weak.size());
  Eigen::MatrixXd axes = Eigen::MatrixXd::Zero(6, count);
  Eigen::MatrixXd without_say = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const WeakDirection& direction = weak[static_cast<size_t>(k)];
    axes.block<3, 1>(direction.is_rotation ? 0 : 3, k) = direction.axis_lidar;
    without_say(k, k) = std::sqrt(1.0 - direction.say);
  }
  // What the prior says of the weak directions, everything else marginalised out.
  const Eigen::MatrixXd marginal = (axes.transpose() * covariance * axes).inverse();
  whole.information +=
      (1.0 - prior.share) * axes * without_say * marginal * without_say * axes.transpose();
  return whole;
}

NormalEquations Linearize(const PriorTerm& prior, const Rigid3d& T) {
  NormalEquations n;
  if (prior.information.isZero(0.0)) return n;
  const Residual<6> residual = EvaluatePosePrior(prior.T, T);
  n.H = residual.J.transpose() * prior.information * residual.J;
  n.b = residual.J.transpose() * prior.information * residual.r;
  n.cost = 0.5 * residual.r.dot(prior.information * residual.r);
  return n;
}

Eigen::Matrix<double, 6, 3> ExtrinsicError::Effect(const Rigid3d& T_ref_body) const {
  // Exp(w) T Exp(-w) = T Exp(Ad(T^-1) w) Exp(-w), T the motion of the camera.
  const Rigid3d T_camref_cam = T_cam_lidar * T_ref_body * T_cam_lidar.Inverse();
  const Matrix6d change = T_camref_cam.Inverse().Adjoint() - Matrix6d::Identity();
  return T_cam_lidar.Inverse().Adjoint() * change.leftCols<3>();
}

NormalEquations WithExtrinsicError(const NormalEquations& visual,
                                   const Eigen::Matrix<double, 6, 3>& effect,
                                   const Eigen::Matrix3d& rotation_covariance) {
  // (C^-1 + E'HE)^-1 = C (I + E'HE C)^-1, which also holds where C is singular.
  const Eigen::Matrix<double, 6, 3> cross = visual.H * effect;
  const Eigen::Matrix3d within = effect.transpose() * cross;
  const Eigen::Matrix3d covariance =
      rotation_covariance * (Eigen::Matrix3d::Identity() + within * rotation_covariance).inverse();
  const Eigen::Matrix3d symmetric = 0.5 * (covariance + covariance.transpose());
  const Eigen::Vector3d gradient = effect.transpose() * visual.b;
  NormalEquations rest = visual;
  rest.H -= cross * symmetric * cross.transpose();
  rest.b -= cross * symmetric * gradient;
  rest.cost -= 0.5 * gradient.dot(symmetric * gradient);
  return rest;
}

PoseProblem::PoseProblem(const PoseProblemSetup& setup, const Executor& executor)
    : setup_(setup), executor_(executor), prior_(setup.prior) {}

void PoseProblem::SetMatches(LaserMatches laser, VisualMatches visual, const Rigid3d& T) {
  laser_ = std::move(laser);
  visual_ = std::move(visual);
  visual_offered_ = visual_.size();
  T_matched_ = T;
  laser_matched_ = Linearize(laser_, T, setup_.bins, setup_.kernel_sigmas, executor_);
  weakness_ = AnalyseWeakness(laser_matched_, Visual(T).normal, setup_.weakness);
  prior_ = WholeAlongWeak(setup_.prior, weakness_.directions);
  if (visual_.size() > 0) visual_ = Gated(T);
}

LaserSum PoseProblem::Laser(const Rigid3d& T) const {
  if (IsSame(T, T_matched_)) return laser_matched_;
  return Linearize(laser_, T, setup_.bins, setup_.kernel_sigmas, executor_);
}

VisualSum PoseProblem::Visual(const Rigid3d& T) const {
  const ExtrinsicError& extrinsics = setup_.extrinsics;
  VisualSum sum = Linearize(visual_, T, extrinsics.T_cam_lidar, setup_.visual_kernel_sigmas);
  if (!extrinsics.rotation_covariance.isZero(0.0)) {
    sum.normal =
        WithExtrinsicError(sum.normal, EffectOfExtrinsics(T), extrinsics.rotation_covariance);
  }
  return sum;
}

Eigen::Matrix<double, 6, 3> PoseProblem::EffectOfExtrinsics(const Rigid3d& T) const {
  return setup_.extrinsics.Effect(setup_.T_ref_seen ? setup_.T_ref_seen->Inverse() * T : T);
}

ShiftedEquations PoseProblem::WithoutCamera(const ShiftedPose& pose) const {
  const Rigid3d T_laser = ShiftedByLaser(pose, weakness_.shift);
  ShiftedEquations sum =
      WithShift(WithBeamErrors(Laser(T_laser), setup_.beam_sigma_rad), pose, weakness_.shift);
  sum.pose += Linearize(prior_, pose.T);
  return sum;
}

ShiftedEquations PoseProblem::Equations(const ShiftedPose& pose) const {
  ShiftedEquations sum = WithoutCamera(pose);
  sum.pose += Visual(pose.T).normal;
  return sum;
}

VisualMatches PoseProblem::Gated(const Rigid3d& T) const {
  PoseSolverOptions solver;
  solver.max_iterations = 2;
  const PoseSolution alone = SolveShiftedPose(
      T, [&](const ShiftedPose& at) { return WithoutCamera(at); }, solver);
  const Eigen::Matrix<double, 6, 3> effect = EffectOfExtrinsics(alone.T);
  const Matrix6d covariance = CovarianceOf(alone.at_T.H, alone.T, setup_.gate_covariance) +
                              effect * setup_.extrinsics.rotation_covariance * effect.transpose();
  return Gate(visual_, alone.T, setup_.extrinsics.T_cam_lidar, covariance,
              setup_.visual_gate_sigmas);
}

PoseSolution PoseProblem::Solve(const Rigid3d& T) const {
  PoseSolverOptions solver;
  solver.max_iterations = 3;
  return SolveShiftedPose(
      T, [&](const ShiftedPose& at) { return Equations(at); }, solver);
}

Matrix6d PoseProblem::CovarianceOf(const Matrix6d& H, const Rigid3d& T,
                                   const CovarianceOptions& options) const {
  const Matrix6d prior = Linearize(prior_, T).H;
  return HonestCovariance(H - prior, setup_.step_m.value_or(T.t().norm()), options, prior);
}

Matrix6d PoseProblem::Covariance(const PoseSolution& solution) const {
  return CovarianceOf(solution.at_T.H, solution.T, setup_.covariance);
}

Matrix6d PoseProblem::Information(const PoseSolution& solution) const {
  return solution.at_T.H - Linearize(prior_, solution.T).H;
}

Matrix6d PoseProblem::CovarianceAt(const Rigid3d& T) const {
  return CovarianceOf(WithoutShift(Equations({T, Vector6d::Zero()})).H, T, setup_.covariance);
}

EstimateEvidence PoseProblem::Evidence(const Rigid3d& T) const {
  const LaserSum laser = Laser(T);
  const VisualSum visual = Visual(T);
  EstimateEvidence evidence;
  evidence.planes = static_cast<int>(laser_.planes.size());
  evidence.edges = static_cast<int>(laser_.lines.size());
  evidence.visual = static_cast<int>(visual_.size());
  evidence.visual_offered = static_cast<int>(visual_offered_);
  evidence.plane_rms_m = Rms(laser.plane_sq_m2, laser_.planes.size());
  evidence.edge_rms_m = Rms(laser.line_sq_m2, laser_.lines.size());
  evidence.visual_rms = Rms(visual.squared, static_cast<size_t>(visual.count));
  return evidence;
}

}  // namespace tvl
