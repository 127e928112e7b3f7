// Lidar points on the camera's normalised plane, in a grid for rectangle queries (paper 4.4.1).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tvl {

// A lidar point as the camera sees it.
struct ProjectedPoint {
  float x = 0, y = 0;  // on the normalised plane (z = 1)
  float depth_m = 0;   // z in the camera frame
  int32_t label = 0;   // SegmentedScan::label
  uint16_t ring = 0;
};

// Part of the normalised plane.
struct NormalisedRect {
  float min_x = 0, min_y = 0, max_x = 0, max_y = 0;

  bool Contains(float x, float y) const {
    return x >= min_x && x <= max_x && y >= min_y && y <= max_y;
  }
};

// Built once a frame, in time linear in the points; no tree. Immutable after construction.
class NormalisedGrid {
 public:
  // Cells of cell_width x cell_height over `bounds`; points outside are left out.
  NormalisedGrid(const std::vector<ProjectedPoint>& points, const NormalisedRect& bounds,
                 float cell_width, float cell_height);

  // Calls visit(const ProjectedPoint&) for every point inside, in a fixed order.
  template <typename Visit>
  void ForEach(const NormalisedRect& rect, const Visit& visit) const {
    const int first_column = Column(rect.min_x), last_column = Column(rect.max_x);
    const int last_row = Row(rect.max_y);
    for (int row = Row(rect.min_y); row <= last_row; ++row) {
      const size_t line = static_cast<size_t>(row) * static_cast<size_t>(columns_);
      const uint32_t begin = start_[line + static_cast<size_t>(first_column)];
      const uint32_t end = start_[line + static_cast<size_t>(last_column) + 1];
      for (uint32_t i = begin; i < end; ++i) {
        if (rect.Contains(points_[i].x, points_[i].y)) visit(points_[i]);
      }
    }
  }

  size_t size() const { return points_.size(); }

 private:
  int Column(float x) const;
  int Row(float y) const;

  NormalisedRect bounds_;
  float columns_per_unit_, rows_per_unit_;
  int columns_, rows_;
  std::vector<uint32_t> start_;         // first point of each cell, row-major, and the end
  std::vector<ProjectedPoint> points_;  // by cell
};

}  // namespace tvl
