// Edge and planar features of a labelled scan (paper 4.3).
#pragma once

#include <vector>

#include "tvl/frame/laser_features.h"
#include "tvl/frame/segmented_scan.h"
#include "tvl/lidar/curvature.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

struct LaserFeatureOptions {
  CurvatureOptions curvature;
  // c_th: a 90 degree corner has c = 0.009..0.0105 at any range where |S| = 10.
  double min_edge_curvature = 0.005;
  // ... but never below this many standard deviations of the noise of c, 1.05 sigma_r / d.
  double edge_noise_sigmas = 4.0;
  int subregions = 6;  // of a row, of equal angle
  int sharp_per_subregion = 2;
  int less_sharp_per_subregion = 20;
  int flat_per_subregion = 4;
  double less_flat_voxel_m = 0.2;  // one planar point a voxel is kept

  void Check() const;
};

// Points of outlier clusters give no features, ground no edges, points near holes, behind
// occlusion borders and on surfaces parallel to the beam none. Features of one ring and kind keep
// the window of Eq. (1) as distance. Order: by row, subregion, then the sharpest (flattest) first.
// Deterministic and thread-safe.
LaserFeatures ExtractLaserFeatures(const SegmentedScan& scan, const LidarModel& model,
                                   const LaserFeatureOptions& options);

// The threshold of Eq. (1) at a range.
float EdgeThreshold(float range_m, const LidarModel& model, const LaserFeatureOptions& options);

}  // namespace tvl
