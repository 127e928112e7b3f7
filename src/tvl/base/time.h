// Time: int64 nanoseconds, so that no stamp ever loses digits.
#pragma once

#include <cmath>
#include <cstdint>

namespace tvl {

// An instant, in nanoseconds since an epoch of the data set's own.
struct Timestamp {
  int64_t ns = 0;

  static Timestamp FromSeconds(double s) { return {static_cast<int64_t>(std::llround(s * 1e9))}; }
  double seconds() const { return static_cast<double>(ns) * 1e-9; }

  friend bool operator==(Timestamp a, Timestamp b) { return a.ns == b.ns; }
  friend bool operator!=(Timestamp a, Timestamp b) { return a.ns != b.ns; }
  friend bool operator<(Timestamp a, Timestamp b) { return a.ns < b.ns; }
  friend bool operator<=(Timestamp a, Timestamp b) { return a.ns <= b.ns; }
};

// later - earlier, in seconds.
inline double SecondsBetween(Timestamp earlier, Timestamp later) {
  return static_cast<double>(later.ns - earlier.ns) * 1e-9;
}

}  // namespace tvl
