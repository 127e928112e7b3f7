// How well a source lies on a submap: the figures a loop is accepted on (paper 6.3, design 4.7).
#pragma once

#include "tvl/loop/loop_source.h"
#include "tvl/loop/loop_submap.h"

namespace tvl {

struct LoopEvidenceOptions {
  double trim_share = 0.8;   // the best of the distances (paper 6.3): what moved may be elsewhere
  double unmatched_m = 1.0;  // the distance of a point without a surfel, and the largest of any
  void Check() const;
};

// What fits and what contradicts, of what stands above the ground.
struct LoopFit {
  double overlap = 0.0;       // share of raised voxels in which the submap has a point
  double seen_through = 0.0;  // share of raised voxels empty in the submap, which looked past them
  int raised = 0;             // voxels judged: only those the submap could see
};

struct LoopEvidence {
  double rms_m = 0.0;         // trimmed, point to plane, all points
  double raised_rms_m = 0.0;  // of those above the ground: the ground fits everywhere
  int planes = 0;             // points judged in rms_m: only those the submap could see
  LoopFit fit;
};

// Enough to tell one alignment from another; a third of the time of the whole evidence.
LoopFit MeasureFit(const LoopSource& source, const LoopSubmap& submap,
                   const Rigid3d& T_odom_current);

LoopEvidence MeasureEvidence(const LoopSource& source, const LoopSubmap& submap,
                             const Rigid3d& T_odom_current, const LoopEvidenceOptions& options);

// Root mean square of the smallest `share` of the distances; 0 of none.
double TrimmedRms_m(std::vector<double> distances_m, double share);

}  // namespace tvl
