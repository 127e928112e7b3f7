// Loops suspected because the estimated positions are close (paper 6.2, vicinity detection).
#pragma once

#include <vector>

#include "tvl/loop/drift_model.h"
#include "tvl/loop/loop_separation.h"
#include "tvl/map/loop.h"

namespace tvl {

struct VicinityOptions {
  // Proposals a keyframe: the closest history keyframe of each earlier pass over the place, closest
  // pass first. A second pass ties three drives together where two would do.
  int max_passes = 2;
  void Check() const;
};

// Proposals for `current`: guess kNone, T_history_current the estimates' own, score the distance
// in m. `linked_path_m` is LinkedPath of `current`.
//
// A linear pass over the positions, not a tree: they change with every optimisation, 4,500 of them
// are read in 13 us, and building a kd-tree over them takes 320. The radius, too,
// differs from keyframe to keyframe.
std::vector<LoopProposal> ProposeVicinity(const KeyframeTrack& track, int current,
                                          const std::vector<double>& linked_path_m,
                                          const DriftRadius& radius,
                                          const LoopSeparationOptions& separation,
                                          const VicinityOptions& options);

}  // namespace tvl
