// A hash map from voxels to values, for maps that are looked up a million times a second.
// Values lie densely in insertion order, so iteration is deterministic.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tvl {

// A cell of a cubic grid. 21 bits an axis: +-1,048,575 cells, 1,000 km at 1 m.
struct VoxelKey {
  int32_t x = 0, y = 0, z = 0;

  // The cell that holds p; size_m is the edge of a cell.
  static VoxelKey Of(const Eigen::Vector3d& p, double size_m) {
    return {static_cast<int32_t>(std::floor(p.x() / size_m)),
            static_cast<int32_t>(std::floor(p.y() / size_m)),
            static_cast<int32_t>(std::floor(p.z() / size_m))};
  }
  Eigen::Vector3d Centre(double size_m) const {
    return size_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
  }
  uint64_t Packed() const {
    constexpr uint64_t kMask = (uint64_t{1} << 21) - 1;
    return ((static_cast<uint64_t>(x) & kMask) << 42) | ((static_cast<uint64_t>(y) & kMask) << 21) |
           (static_cast<uint64_t>(z) & kMask);
  }
  friend bool operator==(const VoxelKey& a, const VoxelKey& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
};

// Open addressing with linear probing; grows at a load of 1/2. No erasure: a map that shrinks is
// rebuilt. Reading from several threads is safe while nobody writes.
template <typename T>
class VoxelHash {
 public:
  struct Entry {
    VoxelKey key;
    T value;
  };

  VoxelHash() { Clear(); }

  size_t size() const { return entries_.size(); }
  const std::vector<Entry>& entries() const { return entries_; }
  std::vector<Entry>& entries() { return entries_; }

  void Clear() {
    entries_.clear();
    slots_.assign(kMinimumSlots, Slot());
  }
  void Reserve(size_t n) {
    entries_.reserve(n);
    while (slots_.size() < 2 * n) Grow();
  }

  // Null where the voxel is not there.
  const T* Find(const VoxelKey& key) const {
    const uint32_t entry = slots_[Probe(key, HashOf(key))].entry;
    return entry == kEmpty ? nullptr : &entries_[entry].value;
  }
  T* Find(const VoxelKey& key) {
    const uint32_t entry = slots_[Probe(key, HashOf(key))].entry;
    return entry == kEmpty ? nullptr : &entries_[entry].value;
  }
  // Inserts a default value where there is none.
  T& operator[](const VoxelKey& key) {
    const uint64_t hash = HashOf(key);
    size_t place = Probe(key, hash);
    if (slots_[place].entry == kEmpty) {
      if (2 * (entries_.size() + 1) > slots_.size()) {
        Grow();
        place = Probe(key, hash);
      }
      slots_[place] = {static_cast<uint32_t>(entries_.size()), TagOf(hash)};
      entries_.push_back({key, T()});
    }
    return entries_[slots_[place].entry].value;
  }

 private:
  static constexpr uint32_t kEmpty = 0xffffffffu;
  static constexpr size_t kMinimumSlots = 1024;

  // Most probes end here: an entry, which lies elsewhere in memory, is read only if tags agree.
  struct Slot {
    uint32_t entry = kEmpty;
    uint32_t tag = 0;
  };

  static uint64_t HashOf(const VoxelKey& key) {
    const uint64_t h = key.Packed() * 0x9e3779b97f4a7c15ULL;
    return h ^ (h >> 32);
  }
  static uint32_t TagOf(uint64_t hash) { return static_cast<uint32_t>(hash >> 32); }

  // Where the key is, or the empty slot where it would be.
  size_t Probe(const VoxelKey& key, uint64_t hash) const {
    const size_t mask = slots_.size() - 1;
    const uint32_t tag = TagOf(hash);
    size_t place = static_cast<size_t>(hash) & mask;
    while (slots_[place].entry != kEmpty &&
           !(slots_[place].tag == tag && entries_[slots_[place].entry].key == key)) {
      place = (place + 1) & mask;
    }
    return place;
  }
  void Grow() {
    slots_.assign(2 * slots_.size(), Slot());
    for (size_t i = 0; i < entries_.size(); ++i) {
      const uint64_t hash = HashOf(entries_[i].key);
      slots_[Probe(entries_[i].key, hash)] = {static_cast<uint32_t>(i), TagOf(hash)};
    }
  }

  std::vector<Slot> slots_;
  std::vector<Entry> entries_;
};

}  // namespace tvl
