// Everything about loop closing that can be set (paper section 6).
#pragma once

#include <string>

#include "tvl/loop/drift_model.h"
#include "tvl/loop/lidar_proposer.h"
#include "tvl/loop/loop_separation.h"
#include "tvl/loop/loop_verification.h"
#include "tvl/loop/vicinity_proposer.h"
#include "tvl/loop/visual_proposer.h"
#include "tvl/pose_graph/batch_pose_graph.h"
#include "tvl/pose_graph/incremental_pose_graph.h"

namespace tvl {

// When a verified loop is believed: by what the graph knows, and by other loops.
struct LoopConsistencyOptions {
  // Chi-square of 6 that 0.1 % of true loops exceed.
  double max_chi2 = 22.5;
  // What no step knows of, one standard deviation: translation and rotation as shares of the linked
  // path (0.5 % is R2 of the paper), and where the path is longer than linked_path_m at least the
  // floor: with it, drift up to R2 (10 m) can be mended, whatever the odometry thinks of itself.
  double drift_share = 0.005;
  double drift_floor_m = 2.0;
  double drift_rad_per_m = 1e-4;
  // Of any link, one standard deviation: what distorts a scan and the few next to it alike, and
  // with that the registrations and the odometry of a metre (de-skewing, calibration).
  double link_floor_m = 0.1, link_floor_rad = 0.003;
  // A loop whose ends are linked by less path than this is believed by itself: the graph is tight.
  double linked_path_m = 60.0;
  // Any other needs so many verified loops that agree with it, their current keyframes
  // min_support_gap_m to max_support_path_m of path apart: one street looks like another for a
  // moment, not while driving along it.
  int min_support = 2;
  double min_support_gap_m = 2.0, max_support_path_m = 40.0;
  // ... and of the comparisons made over max_doubt_path_m of path either way, at least this share
  // must have told: the others found the place ambiguous, things standing where the old pass saw
  // through, or a fit that the graph contradicts. Where streets are identical nearly all do, except
  // for some 60 m round each corner; on streets that are not, hardly any.
  double max_doubt_path_m = 500.0;
  double min_support_share = 0.75;
  // What the graph contradicts may be right all the same, if odometry is worse than thought: up to
  // three times the drift above (chi-square times nine), and only as a row of loops along so much
  // path, each supported by others. One accepted, the graph follows.
  double max_chi2_of_rows = 200.0;
  double min_row_m = 30.0;
  void Check() const;
};

// A loop that reaches the graph has been judged by more than the graph knows. Were it kept waiting
// because it contradicts the odometry's covariance, odometry that is worse than it thinks could
// never be mended. Huber as in the paper; what is wrong nevertheless is dropped by the polish.
inline IncrementalPoseGraphOptions ForJudgedLoops() {
  IncrementalPoseGraphOptions options;
  options.loop_loss = LoopLoss::kHuber;
  options.max_innovation_sq = 1e9;
  return options;
}

struct LoopOptions {
  bool enabled = true;
  bool use_visual = true, use_vicinity = true, use_lidar = true;
  // What was found for a keyframe is applied when so many more have been made, whether it was found
  // at once or just in time: results must not depend on the machine. At 10 frames a second there
  // is a second at least.
  int lag_keyframes = 10;
  // Proposals verified for one keyframe at most, best guess first: the rest are of other places, or
  // of the same with a worse guess.
  int max_verifications = 3;
  // Keyframes that loops of the last so many metres of path link to the newest one are its
  // neighbours: the local map fetches them.
  double connected_path_m = 30.0;
  std::string vocabulary;  // file for the visual proposer; empty: the built-in one
  LoopSeparationOptions separation;
  DriftOptions drift;
  VisualProposerOptions visual;
  VicinityOptions vicinity;
  LidarDescriptorOptions lidar_descriptor;
  LidarProposerOptions lidar;
  LoopVerificationOptions verification;
  LoopConsistencyOptions consistency;
  IncrementalPoseGraphOptions graph = ForJudgedLoops();
  BatchPoseGraphOptions polish;
  void Check() const;
};

}  // namespace tvl
