// Curvature of the points of one ring (paper 4.3, Eq. 1) and which of them are not to be trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tvl {

struct CurvatureOptions {
  // Neighbours on each side, |S| / 2.
  int half_window = 5;
  // At close range S spans this much to each side instead: a corner must stand out of the noise.
  double half_window_m = 0.3;
  int max_half_window = 40;
  // A range step between neighbours up to max_gap_columns apart that hides something behind.
  double occlusion_step_m = 0.3;
  int max_gap_columns = 10;
  // Both neighbours differing by more than this share of the range: the surface lies in the beam.
  double parallel_share = 0.02;

  void Check() const;
};

// Points of one ring in the order of the columns (azimuth falling from +pi).
struct RingPoints {
  std::vector<float> range_m;
  std::vector<float> angle_rad;  // pi - azimuth: rises along the ring, 0..2 pi
};

struct PointCurvature {
  float c = 0;              // Eq. (1); see ComputeCurvature
  int16_t window = 0;       // neighbours used on each side; 0: too few, or a hole nearby: c unknown
  bool unreliable = false;  // behind an occlusion border, or on a surface parallel to the beam
};

// c = |sum over S of (d_j - d_i)| / (|S| d_i), with two refinements that change nothing for evenly
// spaced points of like range. Inverse ranges take the place of ranges: over a plane they run
// straight, however slanted it is, while the range itself curves (c = 0.003 for a wall seen at 80
// deg, more for wider windows). And each side is weighted by the other's mean distance in angle, so
// that missing points do not make slanted surfaces look bent.
// The ring is closed: its ends are neighbours. `column_rad` is the angle of a column.
std::vector<PointCurvature> ComputeCurvature(const RingPoints& ring, double column_rad,
                                             const CurvatureOptions& options);

}  // namespace tvl
