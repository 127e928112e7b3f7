// Options of depth association.
#pragma once

#include "tvl/base/units.h"

namespace tvl {

struct DepthOptions {
  // Neighbourhood: a rectangle on the normalised plane. Its half height is this many of the largest
  // beam gap, so that it always holds two laser lines; 1.2 leaves room for the parallax between the
  // sensors and for beams off their nominal elevation.
  double half_height_gaps = 1.2;
  double default_gap_rad = 0.0087;  // largest beam gap where the sensor model has no beams (HDL-64)
  double half_width_rad = 0.010;    // 6 columns of a 2048-column scan
  // Nearer points are the own vehicle; farther lines lie so sparsely that planes fail
  // (paper 4.4.4).
  double min_depth_m = 0.5;
  double max_depth_m = 50.0;
  // The paper takes labelled points only; outliers are leaves and thin things.
  bool use_outlier_points = false;
  // The largest triangle of the foreground on the normalised plane (squared radians). Two
  // neighbouring columns on two rings 1/3 deg apart span 0.9e-5. A gate in 3D would pass one noisy
  // ring.
  double min_triangle_area_rad_sq = 0.8e-5;
  // Foreground points from which on the plane is fitted to all by least squares; with fewer through
  // the corners of the largest triangle. A huge number gives the paper's three-point fit.
  int least_squares_points = 5;
  // A foreground deeper than the first whose points lie off its plane, along the ray, by more than
  // the second (rms, share of the depth) mixes surfaces. Depth alone says nothing: far ground
  // spreads over metres and is a plane.
  double max_spread_m = 2.0;
  double max_ray_rms = 0.05;
  // Least angle between ray and plane. Grazing planes are carried as uncertain (sigma) instead of
  // dropped: the paper's 10 deg drops all ground beyond 9.4 m.
  double min_incidence_rad = DegToRad(3.5);
  // How far outside the depths of its foreground a feature may come to lie, as a share of its
  // depth: beyond that the plane found is the extension of another surface.
  double max_extrapolation = 0.03;
  // Across the ray, one standard deviation: corner position, calibration and beam direction.
  double sigma_px = 0.7;

  void Check() const;  // throws InputError naming the field
};

}  // namespace tvl
