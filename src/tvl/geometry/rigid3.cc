#include "tvl/geometry/rigid3.h"

#include <Eigen/SVD>
#include <cmath>

namespace tvl {
namespace {

// Below this angle [rad] closed forms lose digits and their series are exact to double precision.
constexpr double kSmallAngle_rad = 1e-4;

// Left Jacobian of SO(3), V in t = V(w) v of the SE(3) exponential.
Eigen::Matrix3d LeftJacobianSo3(const Eigen::Vector3d& w) { return RightJacobianSo3(-w); }

// Off-diagonal block of the left SE(3) Jacobian for [rotation, translation] order
// (Barfoot & Furgale 2014, Q of eq. 7.86 in "State Estimation for Robotics").
Eigen::Matrix3d LeftQ(const Eigen::Vector3d& w, const Eigen::Vector3d& v) {
  const double a = w.norm();
  const Eigen::Matrix3d W = Hat(w), V = Hat(v);
  double c1, c2, c3;
  if (a < 1e-2) {  // series; the closed form cancels to a^5 here
    const double a2 = a * a;
    c1 = 1.0 / 6.0 - a2 / 120.0;
    c2 = 1.0 / 24.0 - a2 / 720.0;
    c3 = 1.0 / 120.0 - a2 / 2520.0;
  } else {
    const double s = std::sin(a), c = std::cos(a), a2 = a * a;
    c1 = (a - s) / (a2 * a);
    c2 = (a2 + 2.0 * c - 2.0) / (2.0 * a2 * a2);
    c3 = (2.0 * a - 3.0 * s + a * c) / (2.0 * a2 * a2 * a);
  }
  const Eigen::Matrix3d WV = W * V, VW = V * W, WVW = W * VW;
  return 0.5 * V + c1 * (WV + VW + WVW) + c2 * (W * WV + VW * W - 3.0 * WVW) +
         c3 * (WVW * W + W * WVW);
}

}  // namespace

Eigen::Matrix3d Hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& w_rad) {
  const double angle_sq = w_rad.squaredNorm();
  const double angle = std::sqrt(angle_sq);
  const double half_sinc =
      angle < kSmallAngle_rad ? 0.5 - angle_sq / 48.0 : std::sin(0.5 * angle) / angle;
  const Eigen::Vector3d v = half_sinc * w_rad;
  return Eigen::Quaterniond(std::cos(0.5 * angle), v.x(), v.y(), v.z());
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d v = q.w() < 0.0 ? Eigen::Vector3d(-q.vec()) : Eigen::Vector3d(q.vec());
  const double w = std::abs(q.w()), n = v.norm();
  const double angle_over_n =
      n < kSmallAngle_rad ? 2.0 / w - 2.0 * n * n / (3.0 * w * w * w) : 2.0 * std::atan2(n, w) / n;
  return angle_over_n * v;
}

Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& w) {
  const double a = w.norm();
  const Eigen::Matrix3d W = Hat(w);
  if (a < kSmallAngle_rad) return Eigen::Matrix3d::Identity() - 0.5 * W + W * W / 6.0;
  const double half_sin = std::sin(0.5 * a);
  return Eigen::Matrix3d::Identity() - 2.0 * half_sin * half_sin / (a * a) * W +
         (a - std::sin(a)) / (a * a * a) * W * W;
}

Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& w) {
  const double a = w.norm();
  const Eigen::Matrix3d W = Hat(w);
  if (a < kSmallAngle_rad) return Eigen::Matrix3d::Identity() + 0.5 * W + W * W / 12.0;
  const double c = 1.0 / (a * a) - 0.5 / (a * std::tan(0.5 * a));
  return Eigen::Matrix3d::Identity() + 0.5 * W + c * W * W;
}

Rigid3d Rigid3d::FromMatrix(const Matrix34d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.leftCols<3>(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
  return {Eigen::Matrix3d(U * svd.matrixV().transpose()), Eigen::Vector3d(m.col(3))};
}

Matrix34d Rigid3d::Matrix() const {
  Matrix34d m;
  m << R(), t_;
  return m;
}

Rigid3d Rigid3d::Exp(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.head<3>(), v = xi.tail<3>();
  return {ExpSo3(w), LeftJacobianSo3(w) * v};
}

Vector6d Rigid3d::Log() const {
  const Eigen::Vector3d w = LogSo3(q_);
  Vector6d xi;
  xi << w, RightJacobianInverseSo3(-w) * t_;
  return xi;
}

Matrix6d Rigid3d::Adjoint() const {
  const Eigen::Matrix3d rotation = R();
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = rotation;
  ad.bottomRightCorner<3, 3>() = rotation;
  ad.bottomLeftCorner<3, 3>() = Hat(t_) * rotation;
  return ad;
}

double Rigid3d::RotationAngle() const { return LogSo3(q_).norm(); }

Rigid3d Scale(double s, const Rigid3d& T) { return Rigid3d::Exp(s * T.Log()); }

Matrix6d RightJacobianSe3(const Vector6d& xi) {
  const Eigen::Vector3d w = -xi.head<3>(), v = -xi.tail<3>();  // Jr(xi) = Jl(-xi)
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = LeftJacobianSo3(w);
  J.bottomRightCorner<3, 3>() = J.topLeftCorner<3, 3>();
  J.bottomLeftCorner<3, 3>() = LeftQ(w, v);
  return J;
}

Matrix6d RightJacobianInverseSe3(const Vector6d& xi) {
  const Eigen::Vector3d w = -xi.head<3>(), v = -xi.tail<3>();
  const Eigen::Matrix3d Jinv = RightJacobianInverseSo3(-w);
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = Jinv;
  J.bottomRightCorner<3, 3>() = Jinv;
  J.bottomLeftCorner<3, 3>() = -Jinv * LeftQ(w, v) * Jinv;
  return J;
}

Matrix6d ScaleJacobian(double s, const Rigid3d& T) {
  const Vector6d xi = T.Log();
  return s * RightJacobianSe3(s * xi) * RightJacobianInverseSe3(xi);
}

}  // namespace tvl
