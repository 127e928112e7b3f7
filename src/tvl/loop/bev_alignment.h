// Correlative alignment of two places seen from above: finds x, y and yaw from far off, where
// registration needs to start within a metre.
//
// What stands above the ground is drawn into a grid (bird's-eye view); every yaw and every shift of
// a window is tried, exhaustively, so that nothing depends on a lucky start. The ground is left
// out: it looks the same everywhere.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/base/parallel.h"

namespace tvl {

// Which points stand more than `height_m` above the lowest point within about 1.5 m of them (3 x 3
// columns of 1 m, along z). 1: raised. Sloping streets (10 degrees: 0.3 m) stay ground.
std::vector<char> AboveGround(const std::vector<Eigen::Vector3f>& points, double height_m);

struct BevSearch {
  double x_m = 0.0, y_m = 0.0;   // middle of the window of translations
  double radius_m = 10.0;        // half its edge
  double yaw_rad = 0.0;          // middle of the window of yaws
  double yaw_window_rad = 0.26;  // half of it; pi tries all
};

struct BevAlignmentOptions {
  double cell_m = 0.5;          // of the grid: registration closes the rest
  double yaw_step_rad = 0.035;  // 2 degrees: at most one cell off at 25 m
  double range_m = 40.0;  // of source points from the current keyframe: beyond, lidar is sparse
  // Peaks nearer to a better one than both of these are its shoulders.
  double peak_distance_m = 2.0, peak_yaw_rad = 0.14;
  int peaks = 3;  // kept at the most: parallel streets give two
  void Check() const;
};

// p_target = Rz(yaw) p_source + (x, y).
struct BevPeak {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0;
  double score = 0.0;  // share of source cells that meet an occupied one (half for a neighbour)
};

// What is aligned with: raised points, and where the ground is known at all. A source that reaches
// beyond the known is judged by the rest. Empty `known`: everything is.
struct BevTarget {
  std::vector<Eigen::Vector2f> raised;  // m
  std::vector<Eigen::Vector2f> known;   // middles of squares of known_m, m
  double known_m = 2.0;
};

// As below, best first by how far an alignment exceeds those up to 4 m beside it, in standard
// errors: where a window leads from known to unknown ground, what is known best would else win.
// BevPeak::score is the share among cells on known ground.
std::vector<BevPeak> AlignBevToKnown(const BevTarget& target,
                                     const std::vector<Eigen::Vector2f>& source,
                                     const BevSearch& search, const BevAlignmentOptions& options,
                                     const Executor& executor);

// The best alignments, best first; empty if either side is. Points are x, y of raised points, in
// metres, duplicates welcome. Deterministic with any number of threads.
std::vector<BevPeak> AlignBev(const std::vector<Eigen::Vector2f>& target,
                              const std::vector<Eigen::Vector2f>& source, const BevSearch& search,
                              const BevAlignmentOptions& options, const Executor& executor);

}  // namespace tvl
