#include "tvl/geometry/camera.h"

namespace tvl {
namespace {

Eigen::Vector2d Distort(const std::array<double, 5>& k, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

}  // namespace

Eigen::Vector2d Camera::Project(const Eigen::Vector2d& normalised) const {
  const Eigen::Vector2d d = IsDistorted() ? Distort(distortion, normalised) : normalised;
  return {fx_px * d.x() + cx_px, fy_px * d.y() + cy_px};
}

Eigen::Vector2d Camera::Unproject(const Eigen::Vector2d& px_cam) const {
  const Eigen::Vector2d d((px_cam.x() - cx_px) / fx_px, (px_cam.y() - cy_px) / fy_px);
  if (!IsDistorted()) return d;
  // Fixed point of n = n - (Distort(n) - d): converges for the mild distortion of usable lenses.
  Eigen::Vector2d n = d;
  for (int i = 0; i < 20; ++i) n -= Distort(distortion, n) - d;
  return n;
}

}  // namespace tvl
