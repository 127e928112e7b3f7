#include "tvl/lidar/voxel_thinning.h"

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {

VoxelThinner::VoxelThinner(double voxel_m) : per_m_(1.0 / voxel_m), slots_(size_t{1} << 15, 0) {
  TVL_CHECK(voxel_m > 0.0) << "voxel " << voxel_m << " m";
}

bool VoxelThinner::IsFirst(const Eigen::Vector3f& p) {
  constexpr double kHalf = 524288.0;  // makes cells positive, where truncation is the floor
  uint64_t key = 1;                   // a leading one: no key is 0
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = static_cast<double>(p[axis]) * per_m_ + kHalf;
    key = (key << 20) | (static_cast<uint64_t>(static_cast<int64_t>(cell)) & 0xfffff);
  }
  if (key == previous_) return false;  // neighbours in a ring mostly share a voxel
  previous_ = key;
  return Insert(key);
}

bool VoxelThinner::Insert(uint64_t key) {
  const size_t mask = slots_.size() - 1;
  size_t i = Rng::Mix(key) & mask;
  for (; slots_[i] != 0; i = (i + 1) & mask) {
    if (slots_[i] == key) return false;
  }
  slots_[i] = key;
  if (2 * ++used_ > slots_.size()) {
    std::vector<uint64_t> old(2 * slots_.size(), 0);
    old.swap(slots_);
    used_ = 0;
    for (const uint64_t k : old) {
      if (k != 0) Insert(k);
    }
  }
  return true;
}

}  // namespace tvl
