// Two rays to one point without known depth: the distance of the reference's ray from the epipolar
// plane of the other. Says nothing of scale, and nothing at all without translation.
#pragma once

#include "tvl/factors/residual.h"

namespace tvl {

struct Epipolar {
  Eigen::Vector3d ray_cam;      // unit, body's camera
  Eigen::Vector3d ray_cam_ref;  // unit, reference's camera
};

// r = ray_ref . n, n the unit normal of the plane of the baseline and the body's ray; about the
// angle off the plane, rad. The baseline of T_ref_body must not vanish.
inline Residual<1> Evaluate(const Epipolar& f, const Rigid3d& T_ref_body, const Rigid3d& T_cam_body,
                            const Matrix6d& Ad_cam_body) {
  const Rigid3d T_camref_cam = T_cam_body * T_ref_body * T_cam_body.Inverse();
  const Eigen::Matrix3d R = T_camref_cam.R();
  const Eigen::Vector3d a = R * f.ray_cam;
  const Eigen::Vector3d m = T_camref_cam.t().cross(a);
  const double length = m.norm();
  const Eigen::Vector3d n = m / length;
  const Eigen::RowVector3d dr_dm = (f.ray_cam_ref - n * n.dot(f.ray_cam_ref)).transpose() / length;
  Residual<1> out;
  out.r[0] = f.ray_cam_ref.dot(n);
  RowVector6d J_cam;
  J_cam.head<3>() = -dr_dm * Hat(T_camref_cam.t()) * R * Hat(f.ray_cam);
  J_cam.tail<3>() = -dr_dm * Hat(a) * R;
  out.J = J_cam * Ad_cam_body;
  return out;
}

}  // namespace tvl
