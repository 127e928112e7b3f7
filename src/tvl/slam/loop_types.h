// What goes into loop closing and what comes out.
#pragma once

#include <string>
#include <vector>

#include "tvl/map/keyframe.h"
#include "tvl/map/loop.h"
#include "tvl/map/pose_graph.h"

namespace tvl {

// What loop closing makes of the keyframes 0..last.
struct LoopUpdate {
  int last = -1;
  std::vector<Rigid3d> T_world_lidar;  // of keyframes 0..last; empty: no loop was closed
  // Keyframes that accepted loops make neighbours of `last`, nearest first.
  std::vector<int> connected;
};

// What became of a proposal.
enum class LoopOutcome {
  kAccepted,
  kRefused,       // by verification: see the verdict
  kInconsistent,  // the graph contradicts it
  kUnsupported,   // verified, but no other loops agree with it
  kCovered,       // another proposal of the keyframe led to the same place
  kNotVerified,   // more proposals than are verified for one keyframe
  kDropped,       // accepted, and contradicted by all the others in the end
};
const char* ToString(LoopOutcome outcome);

struct LoopRecord {
  LoopProposal proposal;
  FrameId history_frame = 0, current_frame = 0;
  Rigid3d T_history_current_graph;  // the graph's estimate when it was proposed
  LoopVerdict verdict;              // of those that were verified
  std::string reason;               // why not accepted; empty for accepted and covered
  LoopOutcome outcome = LoopOutcome::kNotVerified;
  double chi2 = 0.0;  // against the graph and what odometry may drift, 6 degrees of freedom
  double innovation_sq = 0.0;  // by the graph's own covariance alone; 0 for ends linked closely
  double linked_path_m = 0.0;  // between the two when the loop was proposed
  // Path driven when the row of loops began of which each supports the next, up to this one.
  double row_start_m = 0.0;
  double weight = 0.0;          // in the final graph, 0..1; accepted loops only
  bool is_second_look = false;  // at the end of the data
};

// Milliseconds of one keyframe's loop search.
struct LoopTimes {
  double describe_ms = 0.0, propose_visual_ms = 0.0, propose_vicinity_ms = 0.0;
  double propose_lidar_ms = 0.0, verify_ms = 0.0, graph_ms = 0.0, total_ms = 0.0;
};

// All there is to tell of a run's loops.
struct LoopReport {
  std::vector<LoopRecord> records;  // in the order of the proposals
  std::vector<LoopTimes> times;     // one a keyframe
  double second_look_ms = 0.0, polish_ms = 0.0;
  bool second_look_stopped = false;  // by the user, before its end
  // How much larger the odometry's errors turned out, in variance, than its covariances say: 1..25.
  double odometry_variance_factor = 1.0;
  PoseGraph graph;  // as optimised in the end
};

}  // namespace tvl
