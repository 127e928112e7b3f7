// Two rays to one point without known depth: how far they are from lying in one plane with the
// baseline. Says nothing of scale, and nothing at all without translation.
#pragma once

#include <cmath>

#include "tvl/factors/residual.h"

namespace tvl {

struct Epipolar {
  Eigen::Vector3d ray_cam;      // unit, body's camera
  Eigen::Vector3d ray_cam_ref;  // unit, reference's camera
};

// r = t . (a x b) / sqrt(|t x a|^2 + |t x b|^2) with the baseline t, the body's ray a and the
// reference's ray b: the angle, rad, by which both rays together leave the plane that fits them
// best (Sampson 1982). With noise of sigma in each ray its variance is sigma^2 wherever the rays
// and the baseline point. Where it depends on them, as that of one ray's distance from the other's
// plane does, the baseline is drawn towards the side on which there is more to see. The baseline of
// T_ref_body must not vanish.
inline Residual<1> Evaluate(const Epipolar& f, const Rigid3d& T_ref_body, const Rigid3d& T_cam_body,
                            const Matrix6d& Ad_cam_body) {
  const Rigid3d T_camref_cam = T_cam_body * T_ref_body * T_cam_body.Inverse();
  const Eigen::Matrix3d R = T_camref_cam.R();
  const Eigen::Vector3d& t = T_camref_cam.t();
  const Eigen::Vector3d a = R * f.ray_cam;
  const Eigen::Vector3d& b = f.ray_cam_ref;
  const double along_a = t.dot(a), along_b = t.dot(b), length_sq = t.squaredNorm();
  const double scale_sq = 2.0 * length_sq - along_a * along_a - along_b * along_b;
  const double scale = std::sqrt(scale_sq);
  Residual<1> out;
  out.r[0] = t.dot(a.cross(b)) / scale;
  const double share = out.r[0] / scale;
  const Eigen::Vector3d by_t =
      a.cross(b) / scale - share / scale * (2.0 * t - along_a * a - along_b * b);
  const Eigen::Vector3d by_a = b.cross(t) / scale + share / scale * along_a * t;
  RowVector6d J_cam;
  J_cam.head<3>() = -by_a.transpose() * R * Hat(f.ray_cam);
  J_cam.tail<3>() = by_t.transpose() * R;
  out.J = J_cam * Ad_cam_body;
  return out;
}

}  // namespace tvl
