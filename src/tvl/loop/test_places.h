// Places made of random points with random descriptors, and what a camera sees of them. For tests
// only.
#pragma once

#include <cmath>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/frame/image_features.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

inline BinaryDescriptor RandomDescriptor(Rng& rng) {
  return {rng.Next(), rng.Next(), rng.Next(), rng.Next()};
}

// `bits` randomly chosen bits changed (some twice).
inline BinaryDescriptor WithNoise(BinaryDescriptor d, int bits, Rng& rng) {
  for (int i = 0; i < bits; ++i) {
    const auto bit = static_cast<size_t>(rng.Integer(256));
    d[bit / 64] ^= uint64_t{1} << (bit % 64);
  }
  return d;
}

// A point seen by its descriptor.
struct PlacePoint {
  Eigen::Vector3d p_world;
  BinaryDescriptor descriptor;
};
using Place = std::vector<PlacePoint>;

// Points 8 to 30 m ahead of a camera (z forward) at the origin.
inline Place MakePlace(int points, uint64_t seed) {
  Rng rng(seed);
  Place place;
  for (int i = 0; i < points; ++i) {
    const double depth_m = rng.Uniform(8.0, 30.0);
    const Eigen::Vector3d ray(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.2, 0.2), 1.0);
    place.push_back({depth_m * ray, RandomDescriptor(rng)});
  }
  return place;
}

// What a camera at T_world_cam sees: noisy descriptors and rays, a depth for `depth_share` of the
// features, in random order.
inline ImageFeatures See(const Place& place, const Rigid3d& T_world_cam, double depth_share,
                         uint64_t seed) {
  Rng rng(seed);
  ImageFeatures features;
  std::vector<PlacePoint> shuffled = place;
  for (size_t i = shuffled.size(); i > 1; --i) {
    std::swap(shuffled[i - 1], shuffled[static_cast<size_t>(rng.Integer(static_cast<int64_t>(i)))]);
  }
  for (const PlacePoint& point : shuffled) {
    const Eigen::Vector3d p_cam = T_world_cam.Inverse() * point.p_world;
    if (p_cam.z() < 1.0) continue;
    const Eigen::Vector2d noise(rng.Normal(), rng.Normal());
    features.ray_cam.push_back((p_cam.head<2>() / p_cam.z() + 0.0005 * noise).eval().cast<float>());
    features.px_cam.push_back(700.0f * features.ray_cam.back());
    features.depth_m.push_back(rng.Uniform() < depth_share ? static_cast<float>(p_cam.z()) : 0.0f);
    features.descriptors.push_back(WithNoise(point.descriptor, 12, rng));
  }
  return features;
}

}  // namespace tvl
