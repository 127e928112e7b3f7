// Visual residuals on the normalised image plane (paper Eq. 7, in the form that lets the noise of
// the depth enter once). Residuals are in units of the normalised plane: multiply by f for pixels.
#pragma once

#include <Eigen/Core>

#include "tvl/factors/residual.h"

namespace tvl {

// Points nearer than this to the camera plane cannot be projected, m.
inline constexpr double kMinProjectionDepth_m = 0.1;

// d (x/z, y/z) / d p.
inline Eigen::Matrix<double, 2, 3> ProjectionJacobian(const Eigen::Vector3d& p_cam) {
  const double iz = 1.0 / p_cam.z();
  Eigen::Matrix<double, 2, 3> J;
  J << iz, 0.0, -p_cam.x() * iz * iz, 0.0, iz, -p_cam.y() * iz * iz;
  return J;
}

// A point known in the reference frame, seen from the body: depth known at k, reprojected into k+1.
struct Reprojection {
  Eigen::Vector3d p_ref;    // m
  Eigen::Vector2d ray_cam;  // where the body's camera sees it
};

// A point known in the body frame, seen from the reference camera: depth known at k+1 only.
struct InverseReprojection {
  Eigen::Vector3d p_body;       // m
  Eigen::Vector2d ray_cam_ref;  // where the reference's camera saw it
};

// `depth_m` is the z of the point in the camera it is projected into: the residual is meaningless
// below kMinProjectionDepth_m.
struct ProjectedResidual : Residual<2> {
  double depth_m = 0.0;
};

// r = pi(T_cam_body T^-1 p_ref) - ray.
inline ProjectedResidual Evaluate(const Reprojection& f, const Rigid3d& T_ref_body,
                                  const Rigid3d& T_cam_body) {
  const Eigen::Vector3d p_body = T_ref_body.q().conjugate() * (f.p_ref - T_ref_body.t());
  const Eigen::Vector3d p_cam = T_cam_body * p_body;
  const Eigen::Matrix<double, 2, 3> J_body = ProjectionJacobian(p_cam) * T_cam_body.R();
  ProjectedResidual out;
  out.depth_m = p_cam.z();
  out.r = p_cam.head<2>() / p_cam.z() - f.ray_cam;
  out.J.leftCols<3>() = J_body * Hat(p_body);
  out.J.rightCols<3>() = -J_body;
  return out;
}

// r = pi(T_cam_body T p_body) - ray.
inline ProjectedResidual Evaluate(const InverseReprojection& f, const Rigid3d& T_ref_body,
                                  const Rigid3d& T_cam_body) {
  const Eigen::Vector3d p_cam = T_cam_body * (T_ref_body * f.p_body);
  const Eigen::Matrix<double, 2, 3> J_body =
      ProjectionJacobian(p_cam) * T_cam_body.R() * T_ref_body.R();
  ProjectedResidual out;
  out.depth_m = p_cam.z();
  out.r = p_cam.head<2>() / p_cam.z() - f.ray_cam_ref;
  out.J.leftCols<3>() = -J_body * Hat(f.p_body);
  out.J.rightCols<3>() = J_body;
  return out;
}

}  // namespace tvl
