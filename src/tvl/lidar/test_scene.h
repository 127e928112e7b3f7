// A spinning lidar in a world of boxes and planes, for the tests of this folder.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl::test {

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

// Distance along a unit ray from the sensor at the origin, or kNoHit.
using Surface = std::function<double(const Eigen::Vector3d& ray)>;

// Plane n.p = d, where `inside` holds.
inline Surface Plane(
    const Eigen::Vector3d& n, double d,
    const std::function<bool(const Eigen::Vector3d&)>& inside = [](const auto&) { return true; }) {
  return [=](const Eigen::Vector3d& ray) {
    const double range = d / n.dot(ray);
    return range > 0.0 && std::isfinite(range) && inside(range * ray) ? range : kNoHit;
  };
}

inline Surface Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return [=](const Eigen::Vector3d& ray) {
    double enter = 0.0, leave = kNoHit;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = low[axis] / ray[axis], b = high[axis] / ray[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave && enter > 0.0 ? enter : kNoHit;
  };
}

// The two-block HDL-64E of KITTI, without vertical correction.
inline LidarModel Hdl64() {
  LidarModel model;
  model.name = "HDL-64E";
  for (int i = 0; i < 32; ++i) model.beam_elevation_rad.push_back(DegToRad(2.0 - i / 3.0));
  for (int i = 0; i < 32; ++i) model.beam_elevation_rad.push_back(DegToRad(-8.8333 - 0.5 * i));
  model.min_range_m = 1.0;
  return model;
}

struct SimulatedScan {
  LidarScan scan;              // stored ring after ring, azimuth rising from 0
  std::vector<int> surface;    // hit, one a point
  std::vector<uint16_t> ring;  // truth
};

inline SimulatedScan Scan(const std::vector<Surface>& world, const LidarModel& model,
                          double noise_m = 0.0, uint64_t seed = 1, int steps = 2000) {
  SimulatedScan out;
  Rng rng(seed);
  for (int row = 0; row < model.rows(); ++row) {
    const double elevation = model.beam_elevation_rad[static_cast<size_t>(row)];
    for (int step = 0; step < steps; ++step) {
      const double azimuth = 2.0 * kPi * (step + 0.5) / steps;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = kNoHit;
      int hit = -1;
      for (size_t s = 0; s < world.size(); ++s) {
        const double r = world[s](ray);
        if (r < range) range = r, hit = static_cast<int>(s);
      }
      const double noise = noise_m > 0.0 ? noise_m * rng.Normal() : 0.0;
      if (range > model.max_range_m) continue;
      out.scan.points.push_back(((range + noise) * ray).cast<float>());
      out.scan.intensity.push_back(static_cast<float>(step % 100) * 0.01f);
      out.surface.push_back(hit);
      out.ring.push_back(static_cast<uint16_t>(row));
    }
  }
  return out;
}

// Surface index that `p` was simulated on; -1 if it is none of the scan's points.
inline int SurfaceOf(const SimulatedScan& simulated, const Eigen::Vector3f& p) {
  for (size_t i = 0; i < simulated.surface.size(); ++i) {
    if ((simulated.scan.points[i] - p).squaredNorm() < 1e-8f) return simulated.surface[i];
  }
  return -1;
}

}  // namespace tvl::test
