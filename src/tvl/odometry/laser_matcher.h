// Correspondences of the current sharp and flat features among the previous frame's (paper 5.1).
#pragma once

#include <vector>

#include "tvl/odometry/carried_features.h"
#include "tvl/registration/laser_terms.h"

namespace tvl {

// One scan's features to be matched, each moved to the middle of its bin of the sweep.
struct SweepFeatures {
  struct Entry {
    Eigen::Vector3d p_body;  // m, at the middle of its bin
    int bin;
  };
  std::vector<Entry> sharp, flat;
};

// `T_prev_cur` is a guess; its error matters only within a bin (1/128 of the sweep).
SweepFeatures PrepareSweep(const LaserFeatures& features, const SweepBins& bins, double period_s,
                           const Rigid3d& T_prev_cur);

struct LaserMatchOptions {
  double edge_sigma_m = 0.10;   // edges are where beams happen to hit
  double plane_sigma_m = 0.05;  // noise of the point and of a plane through a few points
  void Check() const;
};

// Remembers the planes and lines it has fitted: each is needed in every refresh of a frame.
class LaserMatcher {
 public:
  LaserMatcher(RingCloud less_sharp, RingCloud less_flat);

  // Matches within gate_m at T_prev_cur.
  LaserMatches Match(const SweepFeatures& features, const SweepBins& bins,
                     const Rigid3d& T_prev_cur, double gate_m, const LaserMatchOptions& options);

 private:
  // The fit around the feature of `cloud` nearest to p; null where none is near or valid.
  static const LocalFit* Lookup(const RingCloud& cloud, const Eigen::Vector3d& p, double gate_m,
                                LocalFit (*fit)(const RingCloud&, uint32_t),
                                std::vector<char>* known, std::vector<LocalFit>* fits);
  RingCloud less_sharp_, less_flat_;
  std::vector<char> line_known_, plane_known_;
  std::vector<LocalFit> lines_, planes_;
};

}  // namespace tvl
