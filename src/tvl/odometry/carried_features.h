// The features of frame k as the odometry matches k+1 against them: compensated to t_k, the last
// step of the paper's Algorithm 1.
#pragma once

#include <array>
#include <vector>

#include "tvl/frame/laser_features.h"
#include "tvl/geometry/point_index.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// A point cloud with rings, searchable by distance and, within a ring, by azimuth.
class RingCloud {
 public:
  RingCloud() = default;
  // `points` are compensated, in the lidar frame; `features` give the rings, in the same order.
  RingCloud(std::vector<Eigen::Vector3f> points, const std::vector<LaserFeature>& features);

  size_t size() const { return index_.size(); }
  const Eigen::Vector3f& point(uint32_t i) const { return index_.points()[i]; }
  uint16_t ring(uint32_t i) const { return ring_[i]; }
  // Nearest point to p: at most one neighbour is written; returns how many.
  size_t Nearest(const Eigen::Vector3f& p, Neighbour* out) const {
    return index_.Nearest(p, 1, out);
  }
  // Appends to `out` the at most `count` points of `ring` nearest to p in azimuth and no further
  // than max_distance_m from it.
  void NearestInRing(int ring, const Eigen::Vector3f& p, int count, float max_distance_m,
                     std::vector<uint32_t>* out) const;

 private:
  struct RingEntry {
    float azimuth_rad;
    uint32_t index;
  };
  PointIndex index_;
  std::vector<uint16_t> ring_;
  std::vector<std::vector<RingEntry>> by_azimuth_;  // one a ring, sorted
};

// A plane or line through neighbouring features, with the variance of points about it.
struct LocalFit {
  bool valid = false;
  Eigen::Vector3d axis;  // normal or direction
  Eigen::Vector3d mean;
  double variance_m2 = 0.0;
};

// Plane through the features around feature i: its own ring and the next ones that have any, so
// that at least two rings take part. Invalid where they do not lie on a plane.
LocalFit FitPlaneAround(const RingCloud& cloud, uint32_t i);
// Line through feature i and the nearest features of neighbouring rings.
LocalFit FitLineAround(const RingCloud& cloud, uint32_t i);

}  // namespace tvl
