// Joins the points of a range image into objects (paper 4.2, its reference [2]: Bogoslavskyi &
// Stachniss, Fast range image-based segmentation).
#pragma once

#include <vector>

#include "tvl/frame/segmented_scan.h"

namespace tvl {

struct ClusterOptions {
  // Two neighbours belong together if the line through them and the ray of the farther one
  // enclose more than this.
  double min_angle_rad = 1.0472;  // 60 deg
  // Neighbours whose ranges differ by less than this always do: noise is no gap. At 10 m rays lie
  // 3 cm apart, where 60 deg would cut at 1.8 cm, the noise of one range.
  double range_noise_m = 0.08;
  // Surfaces seen at a slant, as the walls along a street, never pass the angle at 20 m and more.
  // Neighbours in a ring also belong together if they lie on a straight line with the points before
  // and after them, within the tolerance (plus a share of the range, the noise of the azimuth), and
  // the line and the ray enclose more than this.
  double min_line_angle_rad = 0.105;  // 6 deg
  double line_tolerance_m = 0.02;
  double line_tolerance_share = 0.001;
  // Empty cells a link may bridge, in each direction.
  int max_bridged_cells = 1;
  // Kept are clusters with as many points, or with as many rows and points.
  int min_points = 50;
  int min_rows = 3;
  int min_points_with_rows = 5;

  void Check() const;
};

struct ClusterResult {
  std::vector<int32_t> label;  // one a point: kLabelGround, kLabelOutlier or a cluster's
  int clusters = 0;            // kept ones; labels kFirstClusterLabel + 0 .. clusters - 1
  int outliers = 0;            // points of the others
};

// `is_ground` has an entry a point; ground points take no part. Columns wrap around. Clusters are
// numbered by their first point in row-major order. The connected components are found with a
// union-find pass, which gives the very clusters a breadth-first search gives, at a third of the
// time. Deterministic.
ClusterResult FindClusters(const SegmentedScan& scan, const std::vector<uint8_t>& is_ground,
                           const ClusterOptions& options);

}  // namespace tvl
