// A town of facades, trees and parked cars as a lidar's feature points show it. For tests only.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/map/keyframe.h"

namespace tvl::synthetic {

inline constexpr double kLidarHeight_m = 1.7;

// Surface points above the ground z = 0, m.
struct Town {
  std::vector<Eigen::Vector3d> points;

  void AddWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height_m) {
    const int steps = std::max(1, static_cast<int>((to - from).norm() / 0.25));
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d p = from + (to - from) * (static_cast<double>(i) / steps);
      for (double z = 0.2; z < height_m; z += 0.4) points.emplace_back(p.x(), p.y(), z);
    }
  }
  void AddBox(double x0, double y0, double x1, double y1, double height_m) {
    AddWall({x0, y0}, {x1, y0}, height_m);
    AddWall({x1, y0}, {x1, y1}, height_m);
    AddWall({x1, y1}, {x0, y1}, height_m);
    AddWall({x0, y1}, {x0, y0}, height_m);
  }
};

// A street along x, from 0 to length_m, with irregular houses and a row of parked cars.
inline Town Street(double length_m, uint64_t seed) {
  Town town;
  Rng rng(seed);
  for (const double side : {-1.0, 1.0}) {
    for (double x = 0.0; x < length_m;) {
      const double house = rng.Uniform(6.0, 16.0), front = side * rng.Uniform(7.0, 12.0);
      town.AddBox(x, front, x + house, front + side * 9.0, 5.0);
      if (rng.Uniform() < 0.5) {
        const double car = x + rng.Uniform(0.0, 4.0);
        town.AddBox(car, side * 4.5, car + 4.2, side * 6.2, 1.5);
      }
      const double tree = x + rng.Uniform(0.0, house);
      town.AddBox(tree, side * 6.8, tree + 0.5, side * 7.1, 4.0);
      x += house + rng.Uniform(1.0, 9.0);
    }
  }
  return town;
}

// What a lidar at T_town_lidar keeps of it: six points in ten within 60 m, with 3 cm of noise, and
// level ground. `seed` is the scan's.
inline KeyframeCloud Scan(const Town& town, const Rigid3d& T_town_lidar, uint64_t seed) {
  KeyframeCloud cloud;
  Rng rng(seed);
  const Rigid3d T_lidar_town = T_town_lidar.Inverse();
  const auto add = [&](const Eigen::Vector3d& p_town, FeatureCloud* out) {
    Eigen::Vector3d p_lidar = T_lidar_town * p_town;
    if (p_lidar.norm() > 60.0 || rng.Uniform() > 0.6) return;
    for (int axis = 0; axis < 3; ++axis) p_lidar[axis] += 0.03 * rng.Normal();
    out->points.push_back(p_lidar.cast<float>());
    out->intensity.push_back(0.3F);
  };
  for (const Eigen::Vector3d& p : town.points) add(p, p.z() > 2.0 ? &cloud.edges : &cloud.planes);
  const Eigen::Vector3d& here = T_town_lidar.t();
  for (double x = -48.0; x < 48.0; x += 1.0) {
    for (double y = -48.0; y < 48.0; y += 1.0)
      add({here.x() + x, here.y() + y, 0.0}, &cloud.planes);
  }
  return cloud;
}

// A car's pose on the ground.
inline Rigid3d OnGround(double x_m, double y_m, double yaw_rad) {
  return {ExpSo3({0.0, 0.0, yaw_rad}), Eigen::Vector3d(x_m, y_m, kLidarHeight_m)};
}

}  // namespace tvl::synthetic
