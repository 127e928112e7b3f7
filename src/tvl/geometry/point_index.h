// Nearest neighbours among a fixed set of points (nanoflann).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace tvl {

struct Neighbour {
  uint32_t index;
  float distance_sq_m2;
};

// Keeps its own copy of the points. Const methods are safe from several threads.
class PointIndex {
 public:
  PointIndex();
  explicit PointIndex(std::vector<Eigen::Vector3f> points);
  ~PointIndex();
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;

  size_t size() const;
  const std::vector<Eigen::Vector3f>& points() const;

  // Writes at most k neighbours, nearest first, into `out` (room for k); returns how many.
  size_t Nearest(const Eigen::Vector3f& p, size_t k, Neighbour* out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl
