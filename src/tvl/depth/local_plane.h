// The plane through the lidar points around a visual feature (paper 4.4.3, Eq. 2).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "tvl/depth/normalised_grid.h"

namespace tvl {

// A plane that does not pass through the camera, as inverse depth over the normalised plane:
// 1 / z = w^T (x, y, 1). It is n^T X + d = 0 of Eq. (2) with w = -n / d, so that the depth of the
// ray (x, y, 1) is 1 / (w^T (x, y, 1)): negative for a plane behind the camera. In this form a fit
// is linear and its noise is that along the rays, which is where range noise acts.
struct LocalPlane {
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  bool valid = false;  // false: the points span no plane
  double rms_m = 0.0;  // of all the points' distances to the plane, unweighted
  // Variance of the inverse depth at (x, y) is s^2 (x, y, 1) C (x, y, 1)^T for points of inverse
  // depth variance s^2. Relative to `centre`, where it is well conditioned.
  Eigen::Matrix3d cofactor = Eigen::Matrix3d::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();

  double InverseDepth(const Eigen::Vector2d& ray) const { return w.dot(ray.homogeneous()); }
  // Sine of the angle between the ray (x, y, 1) and the plane; 0: grazing.
  double SinIncidence(const Eigen::Vector2d& ray) const;
  // (x, y, 1) C (x, y, 1)^T: 1/n amid n points, growing where the plane is extrapolated.
  double Leverage(const Eigen::Vector2d& ray) const;
};

// Least squares through three or more points; weights fall with the residual once (a leaf in front
// of a wall counts little).
LocalPlane FitPlane(const std::vector<ProjectedPoint>& points);

// Through three points.
LocalPlane PlaneThrough(const std::array<ProjectedPoint, 3>& corners);

// The triangle of largest area on the normalised plane among the points; area 0 for less than
// three. Its corners are ends of rings: only those are looked at.
struct LargestTriangle {
  std::array<ProjectedPoint, 3> corners;
  double area_rad_sq = 0.0;
};
LargestTriangle FindLargestTriangle(const std::vector<ProjectedPoint>& points);

}  // namespace tvl
