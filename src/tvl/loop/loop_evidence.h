// How well a source lies on a submap: the figures a loop is accepted on (paper 6.3, design 4.7).
#pragma once

#include "tvl/loop/loop_source.h"
#include "tvl/loop/loop_submap.h"

namespace tvl {

struct LoopEvidenceOptions {
  // Only what the submap could see counts: points this near to one of its keyframes, horizontally.
  double coverage_m = 25.0;
  double trim_share = 0.8;   // the best of the distances (paper 6.3): what moved may be elsewhere
  double unmatched_m = 1.0;  // the distance of a point without a surfel, and the largest of any
  void Check() const;
};

struct LoopEvidence {
  double rms_m = 0.0;          // trimmed, point to plane, all points
  double raised_rms_m = 0.0;   // of those above the ground: the ground fits everywhere
  double overlap = 0.0;        // share of raised voxels in which the submap has a point
  int planes = 0, raised = 0;  // points counted in rms_m, voxels in overlap
};

LoopEvidence MeasureEvidence(const LoopSource& source, const LoopSubmap& submap,
                             const Rigid3d& T_odom_current, const LoopEvidenceOptions& options);

// Root mean square of the smallest `share` of the distances; 0 of none.
double TrimmedRms_m(std::vector<double> distances_m, double share);

}  // namespace tvl
