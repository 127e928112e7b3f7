// Seeded random numbers, the same on every platform (the standard library's distributions are not).
#pragma once

#include <cmath>
#include <cstdint>

namespace tvl {

// splitmix64 stream. Two generators of one seed and different streams are independent, so that
// frame k of a simulation can be drawn without drawing the frames before it.
class Rng {
 public:
  explicit Rng(uint64_t seed, uint64_t stream = 0) : state_(Mix(seed ^ Mix(stream + kGolden))) {}

  uint64_t Next() {
    state_ += kGolden;
    return Mix(state_);
  }
  // In [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // In [0, n), n > 0.
  int64_t Integer(int64_t n) { return static_cast<int64_t>(Uniform() * static_cast<double>(n)); }
  // Zero mean, unit variance (Box-Muller).
  double Normal() {
    const double u = 1.0 - Uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * 3.14159265358979323846 * Uniform());
  }

  // A hash of one value: for noise that depends on a place, not on an order.
  static uint64_t Mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

 private:
  static constexpr uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
  uint64_t state_;
};

}  // namespace tvl
