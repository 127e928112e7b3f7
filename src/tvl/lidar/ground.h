// Finds the ground in a range image (paper 4.2; the job of its reference [12], done on the image).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/frame/segmented_scan.h"

namespace tvl {

struct GroundOptions {
  // Slope against the local ground above which a surface is no ground.
  double max_slope_rad = 0.1745;  // 10 deg
  // Deviation from the continued local ground, however long the gap between two rings: kerbs and
  // bends of the road pass, hoods, roofs and hedge tops do not.
  double max_step_m = 0.3;
  // Height noise of two neighbouring points: at 4 m rings lie 8 cm apart, where 10 deg are 1.4 cm.
  double height_noise_m = 0.03;
  // Points with a neighbour above them as steep as this belong to something standing.
  double steep_rad = 0.61;  // 35 deg
  // The ground around the sensor: radius, greatest tilt against the sensor's z axis (slope of a
  // ramp plus pitch), tolerance.
  double seed_radius_m = 15.0;
  double max_seed_tilt_rad = 0.21;  // 12 deg
  double seed_tolerance_m = 0.15;
  int min_seed_points = 60;  // fewer: there is no ground

  void Check() const;
};

// Plane z = c + a x + b y of the ground around the sensor, in the lidar frame.
struct GroundSeed {
  bool found = false;
  float a = 0, b = 0, c = 0;
  int inliers = 0;
};

struct GroundResult {
  std::vector<uint8_t> is_ground;  // one a point of the scan
  GroundSeed seed;
  int count = 0;
};

// Seeds with a plane near the sensor (so that it matters little whether the lowest rings see the
// road, the own car, or nothing), then grows ring by ring upwards: along each column while the
// height is continuous and the slope against the ground so far is small, and sideways within a
// ring, which also passes behind what stands in the way.
// Points are ordered by row, then column, as BuildRangeImage leaves them. Deterministic.
GroundResult FindGround(const SegmentedScan& scan, const GroundOptions& options);

// The plane alone; exposed for its test.
GroundSeed FindGroundSeed(const SegmentedScan& scan, const GroundOptions& options);

}  // namespace tvl
