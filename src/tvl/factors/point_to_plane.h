// Distance of a moved point to a plane (paper Eq. 6).
#pragma once

#include "tvl/factors/residual.h"

namespace tvl {

struct PointToPlane {
  Eigen::Vector3d p_body;  // m, moved by T_ref_body
  Eigen::Vector3d n_ref;   // unit normal
  Eigen::Vector3d q_ref;   // a point of the plane, m
};

// r = n . (T p - q), m. T = (R, t).
inline Residual<1> Evaluate(const PointToPlane& f, const Eigen::Matrix3d& R,
                            const Eigen::Vector3d& t) {
  Residual<1> out;
  const Eigen::Vector3d n_body = R.transpose() * f.n_ref;
  out.r[0] = f.n_ref.dot(R * f.p_body + t - f.q_ref);
  out.J.head<3>() = f.p_body.cross(n_body).transpose();
  out.J.tail<3>() = n_body.transpose();
  return out;
}

}  // namespace tvl
