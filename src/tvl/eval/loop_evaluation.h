// Loops against the truth: what was proposed, accepted, wrong, and missed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

struct LoopEvaluationOptions {
  // A revisit: two keyframes within revisit_m by the truth, and so much later.
  double revisit_m = 10.0, min_time_s = 30.0, min_path_m = 50.0;
  // A loop is false if it is off by more than either.
  double false_m = 1.0, false_rad = 0.0873;  // 5 degrees
};

// The keyframes' truth: poses of the lidar in any one world, and the path they lie on.
struct TrueKeyframe {
  Timestamp stamp;
  double path_m = 0.0;
  Rigid3d T_world_lidar;
};

// What one proposer did.
struct ProposerScore {
  int proposals = 0;
  int at_revisits = 0;      // of them, of two keyframes within revisit_m
  int accepted = 0;         // of them, in the final graph
  int keyframes_found = 0;  // revisit keyframes with a proposal at a revisit
  double precision() const { return proposals > 0 ? double(at_revisits) / proposals : 0.0; }
};

struct LoopEvaluation {
  std::array<ProposerScore, kLoopProposers> by_proposer;
  int revisit_keyframes = 0;  // that see a place again
  int closed_keyframes = 0;   // of them, with an accepted loop
  int accepted = 0, false_accepted = 0;
  // Accepted at first, given up in the end: they bent the trajectory meanwhile.
  int dropped = 0, false_dropped = 0;
  // Of accepted loops against the truth.
  double error_p50_m = 0.0, error_p95_m = 0.0, error_p50_rad = 0.0, error_p95_rad = 0.0;
  double recall() const {
    return revisit_keyframes > 0 ? double(closed_keyframes) / revisit_keyframes : 0.0;
  }
};

// How far a record's T_history_current is from the truth.
struct LoopError {
  double translation_m = 0.0, rotation_rad = 0.0;
  double true_distance_m = 0.0;  // between the two keyframes
};
LoopError ErrorOf(const LoopRecord& record, const std::vector<TrueKeyframe>& truth);

// `truth` has one entry a keyframe.
LoopEvaluation EvaluateLoops(const std::vector<LoopRecord>& records,
                             const std::vector<TrueKeyframe>& truth,
                             const LoopEvaluationOptions& options = {});

// A few lines for people.
std::string ToText(const LoopEvaluation& evaluation);

}  // namespace tvl
