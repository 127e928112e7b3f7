// A synthetic world for the tests of the estimators: what a lidar and a camera measure there, with
// the sensor in motion. For tests only.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/laser_features.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sensor/calibration.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl::synthetic {

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

// Distance along a unit ray, or kNoHit.
using Surface =
    std::function<double(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;

inline Surface Plane(const Eigen::Vector3d& n, double d) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) {
    const double range = (d - n.dot(o)) / n.dot(ray);
    return range > 0.0 ? range : kNoHit;
  };
}

// Seen from outside.
inline Surface Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) {
    double enter = 0.0, leave = kNoHit;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - o[axis]) / ray[axis], b = (high[axis] - o[axis]) / ray[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave && enter > 0.0 ? enter : kNoHit;
  };
}

// Along x, seen from inside.
inline Surface Tube(double radius_m) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) {
    const Eigen::Vector2d p = o.tail<2>(), d = ray.tail<2>();
    const double a = d.squaredNorm(), b = p.dot(d), c = p.squaredNorm() - radius_m * radius_m;
    return a < 1e-12 ? kNoHit : (-b + std::sqrt(b * b - a * c)) / a;
  };
}

struct World {
  std::vector<Surface> surfaces;
  std::vector<Eigen::Vector2d> edges;  // x, y of vertical edges

  double Range(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    double range = kNoHit;
    for (const Surface& surface : surfaces) range = std::min(range, surface(origin, ray));
    return range;
  }
};

// A street along x, from -40 to 140 m: floor at z = -1.7, walls, houses that stand out by
// different widths, so that all directions are held.
inline World Street() {
  World world;
  world.surfaces = {Plane({0, 0, 1}, -1.7), Plane({0, -1, 0}, -9), Plane({0, 1, 0}, -8),
                    Plane({-1, 0, 0}, -140), Plane({1, 0, 0}, -40)};
  for (int i = 0; i < 12; ++i) {
    const double x = -35.0 + 14.0 * i, front = 5.0 + i % 3;
    const double side = i % 2 == 0 ? 1.0 : -1.0, back = side > 0 ? 9.0 : -8.0;
    const double y = side * front;
    world.surfaces.push_back(
        Box({x, std::min(y, back), -1.7}, {x + 5.0, std::max(y, back), 5.0 + i % 2}));
    world.edges.emplace_back(x, y);
    world.edges.emplace_back(x + 5.0, y);
  }
  return world;
}

// A featureless tunnel along x: radius 4 m, a floor at z = -1.7.
inline World Tunnel() { return {{Tube(4.0), Plane({0, 0, 1}, -1.7)}, {}}; }

// 40 beams from +6 to -24 degrees.
inline LidarModel Lidar() {
  LidarModel model;
  model.name = "synthetic";
  for (int i = 0; i < 40; ++i) model.beam_elevation_rad.push_back(DegToRad(6.0 - 30.0 * i / 39.0));
  model.columns = 900;
  model.min_range_m = 0.5;
  model.max_range_m = 80.0;
  return model;
}

// x right, y down, z forward; a little above the lidar.
inline Calibration CameraAndLidar() {
  Calibration calibration;
  calibration.camera.fx_px = calibration.camera.fy_px = 350.0;
  calibration.camera.cx_px = 309.5;
  calibration.camera.cy_px = 119.5;
  calibration.camera.width_px = 620;
  calibration.camera.height_px = 240;
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.T_cam_lidar = Rigid3d(R, Eigen::Vector3d(0.06, 0.08, -0.27));
  calibration.T_cam0_lidar = calibration.T_cam_lidar;
  return calibration;
}

// T_world_lidar at so many seconds from the stamp.
using PoseAt = std::function<Rigid3d(double offset_s)>;

inline PoseAt Standing(const Rigid3d& T_world_lidar) {
  return [=](double) { return T_world_lidar; };
}
// Arrives at T_world_prev * T_prev_cur at the stamp, having left T_world_prev a period before.
inline PoseAt Moving(const Rigid3d& T_world_prev, const Rigid3d& T_prev_cur, double period_s) {
  return
      [=](double offset_s) { return T_world_prev * Scale(1.0 + offset_s / period_s, T_prev_cur); };
}

// Seconds from the stamp at which the lidar faces an azimuth.
inline double SpinOffset_s(double azimuth_rad, Deskew spin, double sweep_s) {
  const double sign = spin == Deskew::kNone ? 0.0 : spin == Deskew::kCounterClockwise ? 1.0 : -1.0;
  return sign * azimuth_rad * sweep_s / (2.0 * kPi);
}

inline Eigen::Vector3d Ray(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

struct LaserNoise {
  double range_m = 0.02;
  uint64_t seed = 1;
};

// Flat features: rays at random azimuths.
inline void AddFlat(const World& world, const LidarModel& model, const PoseAt& pose_at, Deskew spin,
                    const LaserNoise& noise, LaserFeatures* features) {
  constexpr int kPerRing = 250;
  Rng rng(noise.seed, 1);
  for (int row = 0; row < model.rows(); ++row) {
    for (int i = 0; i < kPerRing; ++i) {
      const double azimuth = -kPi + 2.0 * kPi * (i + rng.Uniform()) / kPerRing;
      const double offset_s = SpinOffset_s(azimuth, spin, model.sweep_s);
      const Rigid3d T = pose_at(offset_s);
      const Eigen::Vector3d ray = Ray(azimuth, model.beam_elevation_rad[static_cast<size_t>(row)]);
      const double range = world.Range(T.t(), T.q() * ray);
      if (range > model.max_range_m) continue;
      LaserFeature feature;
      feature.p_lidar = ((range + noise.range_m * rng.Normal()) * ray).cast<float>();
      feature.time_offset_s = static_cast<float>(offset_s);
      feature.ring = static_cast<uint16_t>(row);
      features->less_flat.push_back(feature);
      if (i % 8 == 0) features->flat.push_back(feature);
    }
  }
}

// Edge features: where each beam meets the vertical edges in sight.
inline void AddSharp(const World& world, const LidarModel& model, const PoseAt& pose_at,
                     Deskew spin, const LaserNoise& noise, LaserFeatures* features) {
  Rng rng(noise.seed, 2);
  for (const Eigen::Vector2d& edge : world.edges) {
    for (int row = 0; row < model.rows(); ++row) {
      Rigid3d T = pose_at(0.0);
      const double slope = std::tan(model.beam_elevation_rad[static_cast<size_t>(row)]);
      Eigen::Vector3d p;
      double offset_s = 0.0;
      for (int pass = 0; pass < 3; ++pass) {  // the instant depends on where it is seen
        const double z = T.t().z() + slope * (edge - T.t().head<2>()).norm();
        p = T.Inverse() * Eigen::Vector3d(edge.x(), edge.y(), z);
        offset_s = SpinOffset_s(std::atan2(p.y(), p.x()), spin, model.sweep_s);
        T = pose_at(offset_s);
      }
      const double range = p.norm();
      const Eigen::Vector3d p_world = T * p;
      const bool is_seen = world.Range(T.t(), T.q() * p.normalized()) > range - 0.05;
      if (!is_seen || range > 40.0 || p_world.z() < -1.6 || p_world.z() > 5.0) continue;
      LaserFeature feature;
      feature.p_lidar = ((1.0 + noise.range_m * rng.Normal() / range) * p).cast<float>();
      feature.time_offset_s = static_cast<float>(offset_s);
      feature.ring = static_cast<uint16_t>(row);
      features->less_sharp.push_back(feature);
      if (row % 2 == 0) features->sharp.push_back(feature);
    }
  }
}

// What feature extraction would give: points as measured, each at its own time.
inline LaserFeatures SampleFeatures(const World& world, const PoseAt& pose_at, Deskew spin,
                                    const LaserNoise& noise) {
  LaserFeatures features;
  AddFlat(world, Lidar(), pose_at, spin, noise, &features);
  AddSharp(world, Lidar(), pose_at, spin, noise, &features);
  return features;
}

inline std::vector<Eigen::Vector3f> PointsOf(const std::vector<LaserFeature>& features) {
  std::vector<Eigen::Vector3f> points;
  for (const LaserFeature& feature : features) points.push_back(feature.p_lidar);
  return points;
}

// Points of the world's surfaces that a camera at T_world_lidar sees.
inline std::vector<Eigen::Vector3d> Corners(const World& world, const Rigid3d& T_world_lidar,
                                            int count, uint64_t seed) {
  const Calibration calibration = CameraAndLidar();
  const Rigid3d T_world_cam = T_world_lidar * calibration.T_cam_lidar.Inverse();
  Rng rng(seed, 3);
  std::vector<Eigen::Vector3d> corners;
  while (corners.size() < static_cast<size_t>(count)) {
    const Eigen::Vector2d px(rng.Uniform(20, calibration.camera.width_px - 20),
                             rng.Uniform(20, calibration.camera.height_px - 20));
    const Eigen::Vector3d ray =
        (T_world_cam.q() * calibration.camera.Unproject(px).homogeneous()).normalized();
    const double range = world.Range(T_world_cam.t(), ray);
    if (range < 45.0) corners.push_back(T_world_cam.t() + range * ray);
  }
  return corners;
}

// What tracking and depth association would give.
struct Seen {
  FeatureTracks tracks;
  VisualDepths depths;
};

struct CameraNoise {
  double px = 0.3;
  double depth_share = 0.005;  // standard deviation of depths, relative
  int depth_every = 1;         // every n-th id has a depth; 0: none
  uint64_t seed = 1;
};

// The corners in the image from T_world_lidar; the index of a corner is the id of its track.
inline Seen Observe(const std::vector<Eigen::Vector3d>& corners, const Rigid3d& T_world_lidar,
                    const CameraNoise& noise) {
  const Calibration calibration = CameraAndLidar();
  const Camera& camera = calibration.camera;
  const Rigid3d T_cam_world = calibration.T_cam_lidar * T_world_lidar.Inverse();
  Rng rng(noise.seed, 4);
  Seen seen;
  seen.tracks.status = TrackingStatus::kTracked;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d p_cam = T_cam_world * corners[i];
    const double depth = p_cam.z() * (1.0 + noise.depth_share * rng.Normal());
    FeatureTrack track;
    track.id = static_cast<TrackId>(i);
    track.px_cam = camera.Project(p_cam.head<2>() / p_cam.z()) +
                   noise.px * Eigen::Vector2d(rng.Normal(), rng.Normal());
    track.px_cam_prev = track.px_cam;
    track.ray_cam = camera.Unproject(track.px_cam);
    if (p_cam.z() < 1.0 || track.px_cam.minCoeff() < 0.0) continue;
    if (track.px_cam.x() > camera.width_px || track.px_cam.y() > camera.height_px) continue;
    const bool has_depth = noise.depth_every > 0 && i % static_cast<size_t>(noise.depth_every) == 0;
    seen.tracks.tracks.push_back(track);
    seen.depths.push_back(
        has_depth ? VisualDepth{DepthStatus::kOk, depth, std::max(0.02, noise.depth_share * depth)}
                  : VisualDepth{});
  }
  return seen;
}

inline Vector6d Twist(double rx, double ry, double rz, double x, double y, double z) {
  Vector6d xi;
  xi << rx, ry, rz, x, y, z;
  return xi;
}

}  // namespace tvl::synthetic
