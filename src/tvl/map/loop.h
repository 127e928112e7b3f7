// Loops from suspicion to verdict (paper 6.2, 6.3). Data only.
#pragma once

#include <string>

#include "tvl/geometry/rigid3.h"

namespace tvl {

enum class LoopProposer {
  kVisual,    // bag of words over the image
  kVicinity,  // the estimated positions are close
  kLidar,     // the surroundings look alike, from any heading and in the dark
};
inline constexpr int kLoopProposers = 3;
const char* ToString(LoopProposer proposer);

// What a proposer knows of T_history_current.
enum class LoopGuess {
  kNone,  // nothing: the graph's own estimate is the only guess
  kYaw,   // rotation about the vertical; the place to some metres
  kPose,  // all of it
};

// Two keyframes that may show one place.
struct LoopProposal {
  int history = 0, current = 0;  // indices of keyframes, history < current
  LoopProposer proposer = LoopProposer::kVicinity;
  LoopGuess guess = LoopGuess::kNone;
  Rigid3d T_history_current;  // as far as `guess` says
  // How sure the proposer is: visual: normalised similarity, 0..1 or a little above; vicinity:
  // distance, m; lidar: similarity, 0..1.
  double score = 0.0;
  int matches = 0;  // visual: PnP inliers
};

enum class LoopStatus {
  kAccepted,
  kNoStart,       // seen from above, nothing matches
  kFewPoints,     // too little of the current place lies where the history saw
  kWeak,          // the place does not hold all directions (a corridor)
  kHighRms,       // surfaces do not lie on each other
  kLowOverlap,    // what stands above the ground is elsewhere
  kContradicted,  // things stand where the other pass saw through
  kAmbiguous,     // another alignment fits nearly as well
};
const char* ToString(LoopStatus status);

// A proposal after registration, with everything it was judged on.
struct LoopVerdict {
  LoopStatus status = LoopStatus::kNoStart;
  std::string reason;         // why not, with figures; empty if accepted
  Rigid3d T_history_current;  // as registered, also of most that are refused
  // Of T_history_current, right perturbation in the current frame, [rotation, translation].
  Matrix6d covariance = Matrix6d::Identity();
  double rms_m = 0.0;         // trimmed point-to-plane distance
  double raised_rms_m = 0.0;  // of points above the ground alone
  double overlap = 0.0;       // share of voxels above the ground that the history has too, 0..1
  double seen_through = 0.0;  // share of those voxels empty there, with rays passing them
  double ambiguity = 0.0;     // fit (overlap - seen_through) of the second best to the best's
  double coarse_score = 0.0;  // of the bird's-eye-view alignment, 0..1
  double translation_ratio = 0.0, rotation_ratio = 0.0;  // see registration/weakness.h
  int points = 0;                                        // plane points judged

  bool accepted() const { return status == LoopStatus::kAccepted; }
};

}  // namespace tvl
