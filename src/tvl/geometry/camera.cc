#include "tvl/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tvl {
namespace {

using Coefficients = std::array<double, 8>;

// Newton's method doubles its digits with each step; from a lens's worst corner it takes six.
constexpr int kNewtonSteps = 20;
constexpr double kConverged = 1e-14;  // in the normalised image: rounding
// Rays farther from the optical axis are taken as here (89.4 degrees): a normalised image point of
// 100 is beyond anything that is looked at, and its tangent still has all its digits.
constexpr double kMostTheta_rad = 1.56;

Eigen::Vector2d Distort(const Coefficients& k, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

// Fixed point of n = n - (Distort(n) - d): converges for the mild distortion of usable lenses.
Eigen::Vector2d Undistort(const Coefficients& k, const Eigen::Vector2d& d) {
  Eigen::Vector2d n = d;
  for (int i = 0; i < 20; ++i) n -= Distort(k, n) - d;
  return n;
}

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d J_n;  // derivative by the undistorted point
};

Distorted DistortRational(const Coefficients& k, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double above = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double below = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double d_above = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]);
  const double d_below = k[5] + r2 * (2.0 * k[6] + r2 * 3.0 * k[7]);
  const double radial = above / below;
  const double d_radial = (d_above - radial * d_below) / below;  // by r2
  Distorted distorted;
  distorted.point = {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
                     y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
  const double off = 2.0 * x * y * d_radial + 2.0 * k[2] * x + 2.0 * k[3] * y;
  distorted.J_n << radial + 2.0 * x * x * d_radial + 2.0 * k[2] * y + 6.0 * k[3] * x, off,  //
      off, radial + 2.0 * y * y * d_radial + 6.0 * k[2] * y + 2.0 * k[3] * x;
  return distorted;
}

Eigen::Vector2d UndistortRational(const Coefficients& k, const Eigen::Vector2d& d) {
  Eigen::Vector2d n = d;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Distorted at_n = DistortRational(k, n);
    const Eigen::Vector2d step = at_n.J_n.inverse() * (at_n.point - d);
    n -= step;
    if (step.norm() < kConverged * (1.0 + n.norm())) break;
  }
  return n;
}

Eigen::Vector2d DistortEquidistant(const Coefficients& k, const Eigen::Vector2d& n) {
  const double r = n.norm();
  if (r == 0.0) return n;
  const double theta = std::atan(r), t2 = theta * theta;
  return n * (theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
}

Eigen::Vector2d UndistortEquidistant(const Coefficients& k, const Eigen::Vector2d& d) {
  const double theta_d = d.norm();
  if (theta_d == 0.0) return d;
  double theta = std::min(theta_d, kMostTheta_rad);
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double t2 = theta * theta;
    const double value = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    const double slope =
        1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
    const double next = std::clamp(theta - (value - theta_d) / slope, 0.0, kMostTheta_rad);
    const double step = std::abs(next - theta);
    theta = next;
    if (step < kConverged) break;
  }
  return d * (std::tan(theta) / theta_d);
}

}  // namespace

Eigen::Vector2d Camera::Project(const Eigen::Vector2d& normalised) const {
  Eigen::Vector2d d = normalised;
  if (distortion_model == DistortionModel::kEquidistant) {
    d = DistortEquidistant(distortion, normalised);
  } else if (distortion_model == DistortionModel::kRational) {
    d = DistortRational(distortion, normalised).point;
  } else if (IsDistorted()) {
    d = Distort(distortion, normalised);
  }
  return {fx_px * d.x() + cx_px, fy_px * d.y() + cy_px};
}

Eigen::Vector2d Camera::Unproject(const Eigen::Vector2d& px_cam) const {
  const Eigen::Vector2d d((px_cam.x() - cx_px) / fx_px, (px_cam.y() - cy_px) / fy_px);
  if (distortion_model == DistortionModel::kEquidistant) return UndistortEquidistant(distortion, d);
  if (distortion_model == DistortionModel::kRational) return UndistortRational(distortion, d);
  return IsDistorted() ? Undistort(distortion, d) : d;
}

}  // namespace tvl
