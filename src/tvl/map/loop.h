// Loops from suspicion to verdict (paper 6.2, 6.3). Data only.
#pragma once

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

}  // namespace tvl
