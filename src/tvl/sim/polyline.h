// Lines on the ground: driven lines and the axes of streets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace tvl::sim {

// A line through the plane, parametrised by its length from the start.
class Polyline {
 public:
  Polyline() = default;
  // At least two points; neighbours must differ.
  explicit Polyline(std::vector<Eigen::Vector2d> points);

  const std::vector<Eigen::Vector2d>& points() const { return points_; }
  double length_m() const { return s_.back(); }
  // Length from the start to each of points().
  const std::vector<double>& s_m() const { return s_; }

  // Both ends go on straight.
  Eigen::Vector2d At(double s_m) const;
  // Unit direction, from the points 1 m behind and ahead.
  Eigen::Vector2d Tangent(double s_m) const;

  // Points at equal distances of about `step_m`.
  Polyline Resampled(double step_m) const;
  // Moved to the left of its direction (negative: right); corners must be wider than the shift.
  Polyline Shifted(double left_m) const;
  // Both ends carried on straight.
  Polyline Extended(double by_m) const;

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> s_;
};

// The polyline with its corners rounded by arcs of radius_m (less where a leg is too short),
// points step_m apart.
Polyline RoundCorners(const std::vector<Eigen::Vector2d>& corners, double radius_m, double step_m);

// Where a point lies with respect to a set of polylines.
struct PolylineHit {
  double distance_m = std::numeric_limits<double>::infinity();
  int line = -1;
  double s_m = 0.0;
};

// Finds the nearest of many line segments within a limited reach.
class PolylineIndex {
 public:
  // Queries see lines up to reach_m away.
  PolylineIndex(std::vector<Polyline> lines, double reach_m);

  const std::vector<Polyline>& lines() const { return lines_; }
  // Exact within the reach; infinity beyond.
  PolylineHit Nearest(const Eigen::Vector2d& p) const;
  double Distance(const Eigen::Vector2d& p) const { return Nearest(p).distance_m; }

 private:
  struct Segment {
    int line;
    size_t point;
  };
  std::vector<Polyline> lines_;
  double reach_m_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<Segment>> cells_;  // segments within reach of the cell's area
  double cell_m_;
};

}  // namespace tvl::sim
