#include "tvl/lidar/voxel_thinning.h"

#include <cmath>
#include <cstdint>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

// Set of keys by open addressing; 0 marks an empty slot.
class KeySet {
 public:
  explicit KeySet(size_t expected) {
    size_t slots = 64;
    while (slots < 2 * expected) slots *= 2;
    slots_.assign(slots, 0);
  }
  // False if it was there already.
  bool Insert(uint64_t key) {
    const size_t mask = slots_.size() - 1;
    for (size_t i = Rng::Mix(key) & mask;; i = (i + 1) & mask) {
      if (slots_[i] == key) return false;
      if (slots_[i] == 0) {
        slots_[i] = key;
        return true;
      }
    }
  }

 private:
  std::vector<uint64_t> slots_;
};

}  // namespace

std::vector<LaserFeature> ThinByVoxel(const std::vector<LaserFeature>& features, double voxel_m) {
  TVL_CHECK(voxel_m > 0.0) << "voxel " << voxel_m << " m";
  const float per_m = static_cast<float>(1.0 / voxel_m);
  KeySet seen(features.size());
  std::vector<LaserFeature> kept;
  uint64_t previous = 0;
  for (const LaserFeature& feature : features) {
    uint64_t key = 1;  // a leading one: no key is 0
    for (int axis = 0; axis < 3; ++axis) {
      const int64_t cell = static_cast<int64_t>(std::floor(feature.p_lidar[axis] * per_m));
      key = (key << 20) | (static_cast<uint64_t>(cell + (1 << 19)) & 0xfffff);
    }
    if (key == previous) continue;  // neighbours in a ring mostly share a voxel
    previous = key;
    if (seen.Insert(key)) kept.push_back(feature);
  }
  return kept;
}

}  // namespace tvl
