#include "tvl/registration/visual_terms.h"

#include <Eigen/LU>
#include <limits>

#include "tvl/geometry/robust.h"

namespace tvl {
namespace {

template <int N>
void Accumulate(const Residual<N>& residual, const Eigen::Matrix<double, N, N>& information,
                double kernel_sigmas, NormalEquations* sum) {
  const RobustValue robust =
      Huber((residual.r.transpose() * information * residual.r).value(), kernel_sigmas);
  const Eigen::Matrix<double, 6, N> weighted_J =
      residual.J.transpose() * (robust.weight * information);
  sum->H.noalias() += weighted_J * residual.J;
  sum->b.noalias() += weighted_J * residual.r;
  sum->cost += 0.5 * robust.rho;
}

template <typename Match>
void AddProjections(const std::vector<Match>& matches, const Rigid3d& T_ref_body,
                    const Rigid3d& T_cam_body, double kernel_sigmas, VisualSum* sum) {
  for (const Match& match : matches) {
    const ProjectedResidual residual = Evaluate(match.factor, T_ref_body, T_cam_body);
    if (residual.depth_m < kMinProjectionDepth_m) continue;
    Accumulate<2>(residual, match.information, kernel_sigmas, &sum->normal);
    sum->squared += residual.r.squaredNorm();
    ++sum->count;
  }
}

// Squared Mahalanobis distance of a residual under its own noise and the motion's.
template <int N>
double Innovation(const Residual<N>& residual, const Eigen::Matrix<double, N, N>& information,
                  const Matrix6d& covariance) {
  const Eigen::Matrix<double, N, N> S = Eigen::Matrix<double, N, N>(information.inverse()) +
                                        residual.J * covariance * residual.J.transpose();
  return residual.r.dot(S.inverse() * residual.r);
}

template <typename Match>
std::vector<Match> GateProjections(const std::vector<Match>& matches, const Rigid3d& T_ref_body,
                                   const Rigid3d& T_cam_body, const Matrix6d& covariance,
                                   double max_chi2) {
  std::vector<Match> kept;
  for (const Match& match : matches) {
    const ProjectedResidual residual = Evaluate(match.factor, T_ref_body, T_cam_body);
    if (residual.depth_m < kMinProjectionDepth_m) continue;
    if (Innovation<2>(residual, match.information, covariance) < max_chi2) kept.push_back(match);
  }
  return kept;
}

}  // namespace

VisualMatches Gate(const VisualMatches& matches, const Rigid3d& T_ref_body,
                   const Rigid3d& T_cam_body, const Matrix6d& covariance, double gate_sigmas) {
  const double max_chi2 = gate_sigmas * gate_sigmas;
  VisualMatches kept;
  kept.forward = GateProjections(matches.forward, T_ref_body, T_cam_body, covariance, max_chi2);
  kept.inverse = GateProjections(matches.inverse, T_ref_body, T_cam_body, covariance, max_chi2);
  const Matrix6d Ad_cam_body = T_cam_body.Adjoint();
  for (const EpipolarMatch& match : matches.epipolar) {
    const Residual<1> residual = Evaluate(match.factor, T_ref_body, T_cam_body, Ad_cam_body);
    const Eigen::Matrix<double, 1, 1> information(match.information);
    if (Innovation<1>(residual, information, covariance) < max_chi2) kept.epipolar.push_back(match);
  }
  return kept;
}

VisualSum Linearize(const VisualMatches& matches, const Rigid3d& T_ref_body,
                    const Rigid3d& T_cam_body, double kernel_sigmas) {
  VisualSum sum;
  AddProjections(matches.forward, T_ref_body, T_cam_body, kernel_sigmas, &sum);
  AddProjections(matches.inverse, T_ref_body, T_cam_body, kernel_sigmas, &sum);
  const Matrix6d Ad_cam_body = T_cam_body.Adjoint();
  for (const EpipolarMatch& match : matches.epipolar) {
    const Residual<1> residual = Evaluate(match.factor, T_ref_body, T_cam_body, Ad_cam_body);
    Accumulate<1>(residual, Eigen::Matrix<double, 1, 1>(match.information), kernel_sigmas,
                  &sum.normal);
  }
  return sum;
}

double Chi2(const ReprojectionMatch& match, const Rigid3d& T_ref_body, const Rigid3d& T_cam_body) {
  const ProjectedResidual residual = Evaluate(match.factor, T_ref_body, T_cam_body);
  if (residual.depth_m < kMinProjectionDepth_m) return std::numeric_limits<double>::infinity();
  return residual.r.dot(match.information * residual.r);
}

Eigen::Matrix2d RayInformation(double sigma, const Eigen::Matrix<double, 2, 3>& J,
                               const Eigen::Matrix3d& covariance_m2) {
  const Eigen::Matrix2d covariance =
      sigma * sigma * Eigen::Matrix2d::Identity() + J * covariance_m2 * J.transpose();
  return covariance.inverse();
}

}  // namespace tvl
