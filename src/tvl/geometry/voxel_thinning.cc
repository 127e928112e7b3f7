#include "tvl/geometry/voxel_thinning.h"

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

// Voxels numbered in the order of their first point.
class VoxelNumbers {
 public:
  // Room for `expected` voxels; more take longer.
  VoxelNumbers(double voxel_m, size_t expected) : per_m_(1.0 / voxel_m) {
    size_t slots = 64;
    while (slots < 2 * expected) slots *= 2;
    slots_.resize(slots);
  }

  // 20 bits an axis and a leading one: no key is 0.
  uint64_t Key(const Eigen::Vector3f& p) const {
    constexpr double kHalf = 524288.0;  // makes cells positive, where truncation is the floor
    uint64_t key = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = static_cast<double>(p[axis]) * per_m_ + kHalf;
      key = (key << 20) | (static_cast<uint64_t>(static_cast<int64_t>(cell)) & 0xfffff);
    }
    return key;
  }

  uint32_t Number(uint64_t key) {
    Slot& slot = Find(key);
    if (slot.key == 0) {
      slot = {key, used_++};
      const uint32_t number = slot.number;
      if (2 * used_ > slots_.size()) Grow();
      return number;
    }
    return slot.number;
  }

  uint32_t size() const { return used_; }

 private:
  struct Slot {
    uint64_t key = 0;  // 0: empty
    uint32_t number = 0;
  };

  Slot& Find(uint64_t key) {
    const size_t mask = slots_.size() - 1;
    size_t i = Rng::Mix(key) & mask;
    while (slots_[i].key != 0 && slots_[i].key != key) i = (i + 1) & mask;
    return slots_[i];
  }

  void Grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.key != 0) Find(slot.key) = slot;
    }
  }

  double per_m_;
  uint32_t used_ = 0;
  std::vector<Slot> slots_;  // open addressing; a power of two long
};

// Neighbours in a ring that share a voxel.
struct Run {
  uint32_t voxel, begin, size;
};

struct Voxel {
  uint32_t passed = 0, middle = 0;  // points of it so far, and the one to keep
};

// Of the `count` points point(0), point(1), ...
template <typename Point>
std::vector<uint32_t> Middle(size_t count, const Point& point, double voxel_m) {
  TVL_CHECK(voxel_m > 0.0) << "voxel " << voxel_m << " m";
  VoxelNumbers numbers(voxel_m, count / 4);
  std::vector<Run> runs;
  std::vector<uint32_t> counts;
  counts.reserve(count / 4);
  uint64_t previous = 0;
  runs.reserve(count / 4);
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t key = numbers.Key(point(i));
    if (key != previous) {
      runs.push_back({numbers.Number(key), i, 0});
      counts.resize(numbers.size(), 0);
      previous = key;
    }
    ++runs.back().size;
    ++counts[runs.back().voxel];
  }
  std::vector<Voxel> voxels(counts.size());
  for (uint32_t v = 0; v < voxels.size(); ++v) voxels[v].middle = (counts[v] - (v & 1)) / 2;
  std::vector<uint32_t> kept;
  kept.reserve(voxels.size());
  for (const Run& run : runs) {
    Voxel& voxel = voxels[run.voxel];
    const uint32_t offset = voxel.middle - voxel.passed;  // wraps where it has gone by
    if (offset < run.size) kept.push_back(run.begin + offset);
    voxel.passed += run.size;
  }
  return kept;
}

}  // namespace

std::vector<uint32_t> MiddleOfEachVoxel(const std::vector<Eigen::Vector3f>& points,
                                        double voxel_m) {
  return Middle(
      points.size(), [&](uint32_t i) -> const Eigen::Vector3f& { return points[i]; }, voxel_m);
}

std::vector<uint32_t> MiddleOfEachVoxel(const std::vector<Eigen::Vector3f>& points,
                                        const std::vector<uint32_t>& some, double voxel_m) {
  return Middle(
      some.size(), [&](uint32_t i) -> const Eigen::Vector3f& { return points[some[i]]; }, voxel_m);
}

}  // namespace tvl
