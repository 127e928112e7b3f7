#include "tvl/loop/vicinity_proposer.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {

void VicinityOptions::Check() const {
  TVL_CHECK_INPUT(max_passes >= 1) << "max_passes must be at least 1: " << max_passes;
}

std::vector<LoopProposal> ProposeVicinity(const KeyframeTrack& track, int current,
                                          const std::vector<double>& linked_path_m,
                                          const DriftRadius& radius,
                                          const LoopSeparationOptions& separation,
                                          const VicinityOptions& options) {
  const size_t eligible = static_cast<size_t>(EligibleHistory(track, current, separation));
  TVL_CHECK(linked_path_m.size() >= eligible)
      << linked_path_m.size() << " linked paths for " << eligible << " keyframes";
  const Rigid3d& T_world_current = track.T_world_lidar[static_cast<size_t>(current)];
  const auto distance_m = [&](size_t k) {
    return (track.T_world_lidar[k].t() - T_world_current.t()).norm();
  };

  std::vector<int> near;
  for (size_t k = 0; k < eligible; ++k) {
    if (distance_m(k) <= radius.Of(linked_path_m[k])) near.push_back(static_cast<int>(k));
  }
  std::vector<LoopProposal> proposals;
  for (const std::vector<int>& pass : SeparatePasses(near, track.path_m, separation)) {
    LoopProposal best;
    for (const int k : pass) {
      const double d = distance_m(static_cast<size_t>(k));
      if (k != pass.front() && d >= best.score) continue;
      best.history = k;
      best.score = d;
    }
    best.current = current;
    best.proposer = LoopProposer::kVicinity;
    best.guess = LoopGuess::kNone;
    best.T_history_current =
        track.T_world_lidar[static_cast<size_t>(best.history)].Inverse() * T_world_current;
    proposals.push_back(best);
  }
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const LoopProposal& a, const LoopProposal& b) { return a.score < b.score; });
  proposals.resize(std::min(proposals.size(), static_cast<size_t>(options.max_passes)));
  return proposals;
}

}  // namespace tvl
