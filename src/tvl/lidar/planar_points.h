// Laser features of scans without rings: non-repetitive and solid-state lidars, depth cameras,
// merged clouds, and scans whose beams cannot be told from one another. Eq. (1) of the paper looks
// along a ring and says nothing here; planar points are told by the scatter of what lies around
// them in space.
#pragma once

#include "tvl/frame/laser_features.h"
#include "tvl/frame/segmented_scan.h"

namespace tvl {

struct PlanarPointOptions {
  double voxel_m = 0.2;         // one point a voxel is kept (F_lf)
  double coarse_voxel_m = 0.8;  // F_f: the flattest of each
  // Scatter is that of the points within the voxels of this edge around a point's own, 3 x 3 x 3.
  double neighbourhood_m = 0.3;
  int min_neighbours = 8;  // fewer tell nothing of a surface: the point is kept, as not flat
  // Thickness of the neighbourhood above which it is no surface: hedges have 20 to 50 mm and more,
  // walls and roads 6 to 9 mm, ranges a noise of 20 mm.
  double max_thickness_m = 0.06;

  void Check() const;
};

// F_lf and F_f; no edges. Points of outlier clusters give no features. Deterministic.
LaserFeatures FindPlanarPoints(const SegmentedScan& scan, const PlanarPointOptions& options);

}  // namespace tvl
