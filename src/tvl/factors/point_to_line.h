// Distance of a moved point to a line (paper Eq. 5), as its two components across the line.
#pragma once

#include "tvl/factors/residual.h"

namespace tvl {

struct PointToLine {
  Eigen::Vector3d p_body;  // m, moved by T_ref_body
  Eigen::Vector3d d_ref;   // unit direction of the line
  Eigen::Vector3d q_ref;   // a point of the line, m
};

// r = A^T (T p - q), m, with A two unit vectors across the line. T = (R, t).
inline Residual<2> Evaluate(const PointToLine& f, const Eigen::Matrix3d& R,
                            const Eigen::Vector3d& t) {
  Eigen::Matrix<double, 2, 3> A_t;
  A_t.row(0) = f.d_ref.unitOrthogonal().transpose();
  A_t.row(1) = f.d_ref.cross(A_t.row(0).transpose()).transpose();
  const Eigen::Matrix<double, 2, 3> A_body = A_t * R;
  Residual<2> out;
  out.r = A_t * (R * f.p_body + t - f.q_ref);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d a = A_body.row(i).transpose();
    out.J.row(i).head<3>() = f.p_body.cross(a).transpose();
    out.J.row(i).tail<3>() = a.transpose();
  }
  return out;
}

}  // namespace tvl
