// Rejects tracks that break the epipolar geometry of two images (paper 4.1: RANSAC with the
// fundamental matrix).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tvl {

struct EpipolarFilterOptions {
  // Distances are judged at one focal length for all cameras, so that the threshold is an angle:
  // 1 px at 460 px = 2.2 mrad.
  double reference_focal_px = 460.0;
  double max_distance_px = 1.0;  // to the epipolar line, at the reference focal length
  double confidence = 0.99;      // of having drawn one sample free of outliers
  // With less flow than this (median, at the reference focal length) the camera stands or creeps:
  // the geometry is degenerate and would reject good tracks at random; the filter passes all.
  double min_median_flow_px = 1.0;
  int min_points = 15;  // fewer cannot outvote a wrong model (7 points fit one exactly): passes all

  void Check() const;  // throws InputError naming the field
};

// True for each pair that agrees with one rigid motion. `previous` and `current` are normalised,
// undistorted image points (z = 1) of the same features. Deterministic.
std::vector<bool> EpipolarInliers(const std::vector<Eigen::Vector2d>& previous,
                                  const std::vector<Eigen::Vector2d>& current,
                                  const EpipolarFilterOptions& options);

}  // namespace tvl
