#include "tvl/depth/normalised_grid.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// More cells than this help nobody, and a mistaken cell size must not eat the memory.
constexpr int kMaxCells = 4096;

int CellCount(float extent, float cell) {
  const double count = std::ceil(static_cast<double>(extent) / static_cast<double>(cell));
  return static_cast<int>(std::clamp(count, 1.0, static_cast<double>(kMaxCells)));
}

}  // namespace

NormalisedGrid::NormalisedGrid(const std::vector<ProjectedPoint>& points,
                               const NormalisedRect& bounds, float cell_width, float cell_height)
    : bounds_(bounds) {
  TVL_CHECK(cell_width > 0.0f && cell_height > 0.0f) << "cells have a size";
  const float width = std::max(1e-6f, bounds.max_x - bounds.min_x);
  const float height = std::max(1e-6f, bounds.max_y - bounds.min_y);
  columns_ = CellCount(width, cell_width);
  rows_ = CellCount(height, cell_height);
  columns_per_unit_ = static_cast<float>(columns_) / width;
  rows_per_unit_ = static_cast<float>(rows_) / height;

  start_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_) + 1, 0);
  std::vector<uint32_t> cell(points.size());
  constexpr uint32_t kOutside = UINT32_MAX;
  for (size_t i = 0; i < points.size(); ++i) {
    const ProjectedPoint& p = points[i];
    cell[i] = bounds.Contains(p.x, p.y) ? static_cast<uint32_t>(Row(p.y) * columns_ + Column(p.x))
                                        : kOutside;
    if (cell[i] != kOutside) ++start_[cell[i] + 1];
  }
  for (size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  points_.resize(start_.back());
  std::vector<uint32_t> next(start_.begin(), start_.end() - 1);
  for (size_t i = 0; i < points.size(); ++i) {
    if (cell[i] != kOutside) points_[next[cell[i]]++] = points[i];
  }
}

int NormalisedGrid::Column(float x) const {
  return static_cast<int>(
      std::clamp((x - bounds_.min_x) * columns_per_unit_, 0.0f, static_cast<float>(columns_ - 1)));
}

int NormalisedGrid::Row(float y) const {
  return static_cast<int>(
      std::clamp((y - bounds_.min_y) * rows_per_unit_, 0.0f, static_cast<float>(rows_ - 1)));
}

}  // namespace tvl
