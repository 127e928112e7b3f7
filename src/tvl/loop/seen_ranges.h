// How far a keyframe saw in each direction: tells what it could have seen from what was hidden.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/map/keyframe.h"

namespace tvl {

// A coarse range image of one keyframe's features. About 20 kB. Thread-safe.
class SeenRanges {
 public:
  explicit SeenRanges(const KeyframeCloud& cloud);

  // The furthest the keyframe saw towards p_lidar, m; 0 where it measured nothing. Directions are
  // cells of 2 degrees of azimuth and 0.03 of slope: filled by features that lie 0.2 m apart.
  float Towards(const Eigen::Vector3f& p_lidar) const;

 private:
  static size_t CellOf(const Eigen::Vector3f& p_lidar);  // kCells: outside
  void Add(const std::vector<Eigen::Vector3f>& points);

  std::vector<float> range_m_;
};

}  // namespace tvl
