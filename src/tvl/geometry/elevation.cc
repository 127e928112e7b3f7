#include "tvl/geometry/elevation.h"

#include <cmath>

namespace tvl {

std::vector<Eigen::Vector3f> RaiseElevation(const std::vector<Eigen::Vector3f>& points,
                                            double angle_rad) {
  const float c = static_cast<float>(std::cos(angle_rad));
  const float s = static_cast<float>(std::sin(angle_rad));
  std::vector<Eigen::Vector3f> out;
  out.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    const float rho = p.head<2>().norm();
    if (rho <= 0.0f) {
      out.push_back(p);
      continue;
    }
    const float scale = (c * rho - s * p.z()) / rho;
    out.emplace_back(p.x() * scale, p.y() * scale, s * rho + c * p.z());
  }
  return out;
}

}  // namespace tvl
