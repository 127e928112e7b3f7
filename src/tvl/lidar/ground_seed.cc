#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/lidar/ground.h"

namespace tvl {
namespace {

// Points near the sensor that look flat: the surface from the ring below to them is level within
// the greatest tilt. A thinned set, every fourth column.
std::vector<Eigen::Vector3f> FlatPointsNearby(const SegmentedScan& scan,
                                              const GroundOptions& options) {
  const RangeImage& image = scan.image;
  const float radius_m = static_cast<float>(options.seed_radius_m);
  const float slope = static_cast<float>(std::tan(options.max_seed_tilt_rad));
  std::vector<Eigen::Vector3f> flat;
  for (int row = image.rows / 4; row + 1 < image.rows; ++row) {
    for (int column = 0; column < image.columns; column += 4) {
      const int32_t upper = image.point[image.Index(row, column)];
      const int32_t lower = image.point[image.Index(row + 1, column)];
      if (upper == RangeImage::kNoPoint || lower == RangeImage::kNoPoint) continue;
      const Eigen::Vector3f& p = scan.points[static_cast<size_t>(upper)];
      const Eigen::Vector3f& q = scan.points[static_cast<size_t>(lower)];
      const float h_sq = p.head<2>().squaredNorm();
      if (h_sq > radius_m * radius_m) continue;
      const float run = std::sqrt(h_sq) - q.head<2>().norm();
      if (std::abs(p.z() - q.z()) > slope * run) continue;  // the upper ring lies farther out
      flat.push_back(p);
    }
  }
  return flat;
}

// Coefficients (a, b, c) of z = a x + b y + c through three points; not finite if collinear.
Eigen::Vector3f PlaneThrough(const Eigen::Vector3f& p, const Eigen::Vector3f& q,
                             const Eigen::Vector3f& r) {
  const Eigen::Vector3f n = (q - p).cross(r - p);
  if (std::abs(n.z()) < 1e-3f) return Eigen::Vector3f::Constant(std::nanf(""));
  return {-n.x() / n.z(), -n.y() / n.z(), n.dot(p) / n.z()};
}

inline float Distance(const Eigen::Vector3f& plane, const Eigen::Vector3f& p) {
  return p.z() - plane.x() * p.x() - plane.y() * p.y() - plane.z();
}

// Inliers, less the points well below: under the ground there is nothing, so a plane through car
// roofs or a loading bed loses to the road below it.
int Score(const std::vector<Eigen::Vector3f>& points, size_t stride, const Eigen::Vector3f& plane,
          float tolerance_m) {
  int score = 0;
  for (size_t i = 0; i < points.size(); i += stride) {
    const float d = Distance(plane, points[i]);
    score += std::abs(d) < tolerance_m ? 1 : (d < -3.0f * tolerance_m ? -1 : 0);
  }
  return score;
}

Eigen::Vector3f Refine(const std::vector<Eigen::Vector3f>& points, Eigen::Vector3f plane,
                       float tolerance_m) {
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity() * 1e-6;
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& p : points) {
      if (std::abs(Distance(plane, p)) > tolerance_m) continue;
      const Eigen::Vector3d row(p.x(), p.y(), 1.0);
      A += row * row.transpose();
      b += row * static_cast<double>(p.z());
    }
    plane = A.ldlt().solve(b).cast<float>();
  }
  return plane;
}

}  // namespace

GroundSeed FindGroundSeed(const SegmentedScan& scan, const GroundOptions& options) {
  constexpr int kDraws = 60;  // with half the points on the road one in 8 is good
  const std::vector<Eigen::Vector3f> flat = FlatPointsNearby(scan, options);
  GroundSeed seed;
  if (flat.size() < static_cast<size_t>(options.min_seed_points)) return seed;
  const float tilt = static_cast<float>(std::tan(options.max_seed_tilt_rad));
  const float tolerance_m = static_cast<float>(options.seed_tolerance_m);
  const size_t stride = std::max<size_t>(1, flat.size() / 600);
  Rng rng(17);  // always the same draws: the result depends on the scan alone
  Eigen::Vector3f best = Eigen::Vector3f::Zero();
  int best_score = 0;
  const auto draw = [&] {
    return flat[static_cast<size_t>(rng.Integer(static_cast<int64_t>(flat.size())))];
  };
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::Vector3f p = draw(), q = draw(), r = draw();
    const Eigen::Vector3f plane = PlaneThrough(p, q, r);
    if (!(plane.head<2>().norm() <= tilt)) continue;
    const int score = Score(flat, stride, plane, tolerance_m);
    if (score <= best_score) continue;
    best_score = score;
    best = plane;
  }
  if (best_score == 0) return seed;
  best = Refine(flat, best, tolerance_m);
  seed.inliers = static_cast<int>(std::count_if(flat.begin(), flat.end(), [&](const auto& p) {
    return std::abs(Distance(best, p)) < tolerance_m;
  }));
  seed.found = seed.inliers >= options.min_seed_points;
  seed.a = best.x(), seed.b = best.y(), seed.c = best.z();
  return seed;
}

}  // namespace tvl
