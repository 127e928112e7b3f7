// Scans of a room and comparisons of surfel maps, for tests.
#pragma once

#include <cstring>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/registration/surfel_map.h"

namespace tvl::synthetic {

using Points = std::vector<Eigen::Vector3f>;

// Points of a room of 16 x 16 x 6 m about the sensor, with clutter.
inline Points RoomScan(uint64_t seed, int count = 6000) {
  Rng rng(seed);
  Points points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(rng.Uniform(-8, 8), rng.Uniform(-8, 8), rng.Uniform(-2, 4));
    if (i % 7 != 0) p[i % 3] = (i % 2 == 0 ? 1.0 : -1.0) * (i % 3 == 2 ? 2.0 : 8.0);
    for (int a = 0; a < 3; ++a) p[a] += 0.02 * rng.Normal();
    points.push_back(p.cast<float>());
  }
  return points;
}

inline Rigid3d SomePose(uint64_t seed) {
  Rng rng(seed);
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? 0.3 : 4.0) * rng.Normal();
  return Rigid3d::Exp(xi);
}

inline std::vector<Eigen::Vector3d> Queries(uint64_t seed, int count = 3000) {
  Rng rng(seed);
  std::vector<Eigen::Vector3d> queries;
  for (int i = 0; i < count; ++i) {
    queries.push_back({rng.Uniform(-14, 14), rng.Uniform(-14, 14), rng.Uniform(-6, 6)});
  }
  return queries;
}

inline bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(double)) == 0; }

inline bool SameBits(const Surfel& a, const Surfel& b) {
  bool same = a.kind == b.kind && SameBits(a.count, b.count) &&
              SameBits(a.thickness_sq_m2, b.thickness_sq_m2) &&
              SameBits(a.extent_sq_m2, b.extent_sq_m2);
  for (int i = 0; i < 3; ++i) {
    same = same && SameBits(a.mean[i], b.mean[i]) && SameBits(a.axis[i], b.axis[i]);
  }
  return same;
}

// Queries both maps answer differently, to the bit.
inline int Differences(const SurfelMap& a, const SurfelMap& b) {
  int differences = 0;
  for (const Eigen::Vector3d& p : Queries(99)) {
    const Surfel *in_a = a.Find(p), *in_b = b.Find(p);
    const bool same =
        (in_a == nullptr) == (in_b == nullptr) && (in_a == nullptr || SameBits(*in_a, *in_b));
    if (!same) ++differences;
  }
  return differences;
}

inline int Answered(const SurfelMap& map) {
  int answered = 0;
  for (const Eigen::Vector3d& p : Queries(99)) answered += map.Find(p) != nullptr;
  return answered;
}

}  // namespace tvl::synthetic
