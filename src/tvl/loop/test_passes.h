// Keyframes of two drives through synthetic worlds, with the drift between them. For tests only.
#pragma once

#include <memory>
#include <vector>

#include "tvl/loop/loop_submap.h"
#include "tvl/registration/test_world.h"

namespace tvl::synthetic {

struct Passes {
  std::vector<Rigid3d> T_world_lidar;  // truth
  std::vector<Rigid3d> T_odom_lidar;
  std::vector<std::shared_ptr<const KeyframeCloud>> clouds;

  int size() const { return static_cast<int>(clouds.size()); }
  KeyframeCloudSource Source() const {
    return [this](int k) { return clouds.at(static_cast<size_t>(k)); };
  }
  Rigid3d Truth_T_history_current(int history, int current) const {
    return T_world_lidar[static_cast<size_t>(history)].Inverse() *
           T_world_lidar[static_cast<size_t>(current)];
  }

  // A keyframe at T_world_lidar, whose odometry has drifted by T_odom_world.
  void Add(const World& world, const Rigid3d& T_world, const Rigid3d& T_odom_world) {
    const LaserNoise noise{0.02, static_cast<uint64_t>(clouds.size() + 1)};
    const LaserFeatures features = SampleFeatures(world, Standing(T_world), Deskew::kNone, noise);
    auto cloud = std::make_shared<KeyframeCloud>();
    cloud->planes.points = PointsOf(features.less_flat);
    cloud->edges.points = PointsOf(features.less_sharp);
    clouds.push_back(cloud);
    T_world_lidar.push_back(T_world);
    T_odom_lidar.push_back(T_odom_world * T_world);
  }
};

inline Rigid3d OnStreet(double x_m, double y_m, double yaw_rad) {
  return Rigid3d::Translation(x_m, y_m, 0.0) * Rigid3d::Exp(Twist(0, 0, yaw_rad, 0, 0, 0));
}

// First pass: keyframes 0..40 at x = 10..50, y = 1 m along `first`, forwards. Second: keyframes
// 41..56 at y = -1 m along `second`, drifted by metres; forwards x = 20..35, or back 45..30.
inline Passes TwoPasses(const World& first, const World& second, bool is_reverse) {
  const Rigid3d T_drift = Rigid3d::Exp(Twist(0.005, -0.004, 0.06, 4.0, -3.0, 0.8));
  Passes passes;
  for (int k = 0; k <= 40; ++k) passes.Add(first, OnStreet(10.0 + k, 1.0, 0.0), Rigid3d());
  for (int k = 0; k <= 15; ++k) {
    const Rigid3d T = is_reverse ? OnStreet(45.0 - k, -1.0, kPi) : OnStreet(20.0 + k, -1.0, 0.0);
    passes.Add(second, T, T_drift);
  }
  return passes;
}

// Houses of all sizes along x, as the seed says, from -60 to 130 m; open between them.
inline World RandomHouses(uint64_t seed) {
  World world;
  world.surfaces = {Plane({0, 0, 1}, -1.7)};
  Rng rng(seed);
  for (const double side : {-1.0, 1.0}) {
    double x = -60.0 + rng.Uniform(0.0, 8.0);
    while (x < 130.0) {
      const double width = rng.Uniform(4.0, 14.0), depth = rng.Uniform(3.0, 10.0);
      const double front = side * rng.Uniform(4.5, 10.0), back = front + side * depth;
      world.surfaces.push_back(Box({x, std::min(front, back), -1.7},
                                   {x + width, std::max(front, back), rng.Uniform(2.0, 6.0)}));
      world.edges.emplace_back(x, front);
      world.edges.emplace_back(x + width, front);
      x += width + rng.Uniform(2.0, 12.0);
    }
  }
  return world;
}

// Houses every 12 m, all alike.
inline World IdenticalHouses() {
  World world;
  world.surfaces = {Plane({0, 0, 1}, -1.7), Plane({0, -1, 0}, -9), Plane({0, 1, 0}, -8)};
  for (int i = -10; i < 20; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double x = 12.0 * i, y = side * 6.0, back = side > 0 ? 9.0 : -8.0;
      world.surfaces.push_back(
          Box({x, std::min(y, back), -1.7}, {x + 6.0, std::max(y, back), 5.0}));
      world.edges.emplace_back(x, y);
      world.edges.emplace_back(x + 6.0, y);
    }
  }
  return world;
}

}  // namespace tvl::synthetic
