#include "tvl/depth/local_plane.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tvl {
namespace {

Eigen::Vector3d Row(const ProjectedPoint& p, const Eigen::Vector2d& centre) {
  return {static_cast<double>(p.x) - centre.x(), static_cast<double>(p.y) - centre.y(), 1.0};
}

// w of coordinates relative to the centre, in plain coordinates.
Eigen::Vector3d Uncentred(const Eigen::Vector3d& w, const Eigen::Vector2d& centre) {
  return {w.x(), w.y(), w.z() - w.x() * centre.x() - w.y() * centre.y()};
}

// Distance of a point to the plane, m.
double Distance_m(const LocalPlane& plane, const ProjectedPoint& p) {
  const double z = static_cast<double>(p.depth_m);
  const Eigen::Vector3d X(static_cast<double>(p.x) * z, static_cast<double>(p.y) * z, z);
  return (plane.w.dot(X) - 1.0) / std::max(1e-12, plane.w.norm());
}

// One weighted linear fit; `weight` as long as the points.
LocalPlane Solve(const std::vector<ProjectedPoint>& points, const std::vector<double>& weight) {
  LocalPlane plane;
  double total = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    plane.centre += weight[i] * Eigen::Vector2d(points[i].x, points[i].y);
    total += weight[i];
  }
  plane.centre /= total;
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d row = Row(points[i], plane.centre);
    A += weight[i] * row * row.transpose();
    b += weight[i] / static_cast<double>(points[i].depth_m) * row;
  }
  const double det = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  // Points on a line: spread across it under a ten-thousandth of that along it.
  const double trace = A(0, 0) + A(1, 1);
  if (!(det > 1e-8 * trace * trace)) return plane;
  plane.cofactor = A.inverse();
  plane.w = Uncentred(plane.cofactor * b, plane.centre);
  plane.valid = true;
  double sum = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double d = Distance_m(plane, points[i]);
    sum += d * d;
  }
  plane.rms_m = std::sqrt(sum / static_cast<double>(points.size()));
  return plane;
}

// The points that can be corners of the largest triangle: leftmost and rightmost of each ring.
std::vector<ProjectedPoint> RingEnds(std::vector<ProjectedPoint> points) {
  std::sort(points.begin(), points.end(), [](const ProjectedPoint& a, const ProjectedPoint& b) {
    if (a.ring != b.ring) return a.ring < b.ring;
    return a.x != b.x ? a.x < b.x : a.y < b.y;
  });
  std::vector<ProjectedPoint> ends;
  for (size_t i = 0; i < points.size(); ++i) {
    const bool first = i == 0 || points[i - 1].ring != points[i].ring;
    const bool last = i + 1 == points.size() || points[i + 1].ring != points[i].ring;
    if (first || last) ends.push_back(points[i]);
  }
  return ends;
}

double Area(const ProjectedPoint& a, const ProjectedPoint& b, const ProjectedPoint& c) {
  return 0.5 * static_cast<double>(std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)));
}

}  // namespace

double LocalPlane::SinIncidence(const Eigen::Vector2d& ray) const {
  return std::abs(InverseDepth(ray)) / std::max(1e-12, w.norm() * ray.homogeneous().norm());
}

double LocalPlane::Leverage(const Eigen::Vector2d& ray) const {
  const Eigen::Vector3d row = (ray - centre).homogeneous();
  return row.dot(cofactor * row);
}

LocalPlane FitPlane(const std::vector<ProjectedPoint>& points) {
  if (points.size() < 3) return {};
  std::vector<double> weight(points.size(), 1.0);
  LocalPlane plane = Solve(points, weight);
  if (!plane.valid || points.size() < 5) return plane;
  const double scale_m = std::max(0.03, 1.5 * plane.rms_m);  // not below the noise of a range
  for (size_t i = 0; i < points.size(); ++i) {
    const double r = Distance_m(plane, points[i]) / scale_m;
    weight[i] = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
  }
  const LocalPlane refit = Solve(points, weight);
  return refit.valid ? refit : plane;
}

LocalPlane PlaneThrough(const std::array<ProjectedPoint, 3>& corners) {
  return Solve({corners.begin(), corners.end()}, {1.0, 1.0, 1.0});
}

LargestTriangle FindLargestTriangle(const std::vector<ProjectedPoint>& points) {
  const std::vector<ProjectedPoint> ends = RingEnds(points);
  LargestTriangle best;
  for (size_t i = 0; i < ends.size(); ++i) {
    for (size_t j = i + 1; j < ends.size(); ++j) {
      for (size_t k = j + 1; k < ends.size(); ++k) {
        const double area = Area(ends[i], ends[j], ends[k]);
        if (area > best.area_rad_sq) best = {{ends[i], ends[j], ends[k]}, area};
      }
    }
  }
  return best;
}

}  // namespace tvl
