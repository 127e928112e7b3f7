// Visual residuals, summed into normal equations (paper Eq. 7, 8).
#pragma once

#include <vector>

#include "tvl/factors/epipolar.h"
#include "tvl/factors/reprojection.h"
#include "tvl/optim/pose_solver.h"

namespace tvl {

// Information of a 2-vector on the normalised plane.
struct ReprojectionMatch {
  Reprojection factor;
  Eigen::Matrix2d information;
  size_t source = 0;  // index the caller knows it by
};

struct InverseReprojectionMatch {
  InverseReprojection factor;
  Eigen::Matrix2d information;
};

struct EpipolarMatch {
  Epipolar factor;
  double information;  // 1 / rad^2
};

struct VisualMatches {
  std::vector<ReprojectionMatch> forward;
  std::vector<InverseReprojectionMatch> inverse;
  std::vector<EpipolarMatch> epipolar;

  size_t size() const { return forward.size() + inverse.size() + epipolar.size(); }
};

struct VisualSum {
  NormalEquations normal;
  double squared = 0.0;  // sum of squared reprojection residuals, normalised plane
  int count = 0;         // reprojection residuals in it
};

// At motion T_ref_body, with a Huber kernel of width `kernel_sigmas` on whitened residuals.
// Points behind the camera contribute nothing.
VisualSum Linearize(const VisualMatches& matches, const Rigid3d& T_ref_body,
                    const Rigid3d& T_cam_body, double kernel_sigmas);

// The matches that agree with a motion known without the camera: T_ref_body with covariance
// `covariance` (right perturbation). A residual must lie within `gate_sigmas` of its own noise and
// that of the motion together: features on moving cars do not, however many they are.
VisualMatches Gate(const VisualMatches& matches, const Rigid3d& T_ref_body,
                   const Rigid3d& T_cam_body, const Matrix6d& covariance, double gate_sigmas);

// Whitened squared residual of one match at T; infinite behind the camera. For gating.
double Chi2(const ReprojectionMatch& match, const Rigid3d& T_ref_body, const Rigid3d& T_cam_body);

// Information of an observed ray with pixel noise sigma (normalised plane) of a point with
// covariance `covariance_m2` in the frame that `J` (d projection / d point, 2x3) refers to.
Eigen::Matrix2d RayInformation(double sigma, const Eigen::Matrix<double, 2, 3>& J,
                               const Eigen::Matrix3d& covariance_m2);

}  // namespace tvl
