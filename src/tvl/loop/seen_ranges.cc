#include "tvl/loop/seen_ranges.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/units.h"

namespace tvl {
namespace {

constexpr int kColumns = 180, kRows = 60;
constexpr size_t kCells = static_cast<size_t>(kColumns) * kRows;
constexpr float kSlopeStep = 0.03f;

}  // namespace

SeenRanges::SeenRanges(const KeyframeCloud& cloud) : range_m_(kCells, 0.0f) {
  Add(cloud.planes.points);
  Add(cloud.edges.points);
}

void SeenRanges::Add(const std::vector<Eigen::Vector3f>& points) {
  for (const Eigen::Vector3f& p : points) {
    const size_t cell = CellOf(p);
    if (cell < kCells) range_m_[cell] = std::max(range_m_[cell], p.norm());
  }
}

size_t SeenRanges::CellOf(const Eigen::Vector3f& p) {
  const float horizontal_m = p.head<2>().norm();
  if (horizontal_m < 0.1f) return kCells;
  const float slope = p.z() / (horizontal_m * kSlopeStep) + 0.5f * kRows;
  if (!(slope >= 0.0f && slope < kRows)) return kCells;
  const float turn = 0.5f + std::atan2(p.y(), p.x()) * static_cast<float>(0.5 / kPi);  // 0..1
  const int column = std::clamp(static_cast<int>(turn * kColumns), 0, kColumns - 1);
  return static_cast<size_t>(slope) * kColumns + static_cast<size_t>(column);
}

float SeenRanges::Towards(const Eigen::Vector3f& p_lidar) const {
  const size_t cell = CellOf(p_lidar);
  return cell < kCells ? range_m_[cell] : 0.0f;
}

}  // namespace tvl
