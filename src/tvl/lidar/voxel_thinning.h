// Keeps one point a voxel.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tvl {

// Tells, point by point, which is the first in its voxel (grid aligned to the frame of the points).
// A hash set of the voxels seen, so the answer depends on the order of the points alone.
// Coordinates within +-500,000 voxels. Not for two threads at once.
class VoxelThinner {
 public:
  // Throws Error for a size <= 0.
  explicit VoxelThinner(double voxel_m);
  bool IsFirst(const Eigen::Vector3f& p);

 private:
  bool Insert(uint64_t key);

  double per_m_;
  uint64_t previous_ = 0;
  size_t used_ = 0;
  std::vector<uint64_t> slots_;  // open addressing, 0 is empty; a power of two long
};

}  // namespace tvl
