// Rigid motions in 3D.
//
// Naming: T_target_source maps p_target = T_target_source * p_source; neighbouring frames cancel:
// T_a_c = T_a_b * T_b_c. Tangent vectors are ordered [rotation, translation] and perturb on the
// right: T * Exp(xi).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tvl {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using RowVector6d = Eigen::Matrix<double, 1, 6>;
using Matrix34d = Eigen::Matrix<double, 3, 4>;

// Skew-symmetric matrix with Hat(a) * b = a x b.
Eigen::Matrix3d Hat(const Eigen::Vector3d& a);

// SO(3) exponential and logarithm; exact through zero. Log is in [0, pi].
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& w_rad);
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q);
// Exp(w + dw) = Exp(w) Exp(Jr(w) dw) to first order.
Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& w_rad);
Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& w_rad);

// SE(3) value. Thread-safe for reading.
class Rigid3d {
 public:
  Rigid3d() : q_(Eigen::Quaterniond::Identity()), t_(Eigen::Vector3d::Zero()) {}
  Rigid3d(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : q_(q.normalized()), t_(t) {}
  Rigid3d(const Eigen::Matrix3d& R, const Eigen::Vector3d& t)
      : q_(Eigen::Quaterniond(R).normalized()), t_(t) {}
  // From the upper three rows of a homogeneous matrix, its rotation made orthonormal.
  static Rigid3d FromMatrix(const Matrix34d& m);
  static Rigid3d Translation(double x, double y, double z) {
    return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)};
  }

  // SE(3) exponential and logarithm of xi = [rotation (rad), translation (m)].
  static Rigid3d Exp(const Vector6d& xi);
  Vector6d Log() const;

  const Eigen::Quaterniond& q() const { return q_; }
  const Eigen::Vector3d& t() const { return t_; }
  Eigen::Matrix3d R() const { return q_.toRotationMatrix(); }
  Matrix34d Matrix() const;

  Rigid3d Inverse() const {
    const Eigen::Quaterniond q_inv = q_.conjugate();
    return {q_inv, -(q_inv * t_)};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return q_ * p + t_; }
  Rigid3d operator*(const Rigid3d& other) const { return {q_ * other.q_, q_ * other.t_ + t_}; }

  // Ad with T * Exp(xi) = Exp(Ad * xi) * T.
  Matrix6d Adjoint() const;

  double RotationAngle() const;  // rad, in [0, pi]

 private:
  Eigen::Quaterniond q_;
  Eigen::Vector3d t_;
};

// Exp(s * Log(T)): the motion T at a constant velocity for a share s of its time; paper Eq. (3).
Rigid3d Scale(double s, const Rigid3d& T);

// Right Jacobian of SE(3): Exp(xi + d) = Exp(xi) Exp(Jr(xi) d) to first order, and its inverse.
Matrix6d RightJacobianSe3(const Vector6d& xi);
Matrix6d RightJacobianInverseSe3(const Vector6d& xi);

// d Scale(s, T Exp(d)) / d d as a right perturbation: s * Jr(s Log T) * Jr^-1(Log T).
// It is not s * Identity (the trap of paper Eq. 3).
Matrix6d ScaleJacobian(double s, const Rigid3d& T);

}  // namespace tvl
