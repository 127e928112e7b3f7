// The loops of a run, for people and programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tvl/eval/loop_evaluation.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

// loops.csv: a line for every proposal: which keyframes, by whom, on what evidence, and what became
// of it. With `truth` (one entry a keyframe; may be empty) also how far off it is.
std::string LoopTable(const LoopReport& report, const std::vector<TrueKeyframe>& truth);

// Counts by proposer and outcome, times of the stages; `odometry_variance_factor`: how much larger
// the odometry's errors are, in variance, than its covariances say. `truth` as above.
nlohmann::json LoopsToJson(const LoopReport& report, const std::vector<TrueKeyframe>& truth);

// graph.g2o: the keyframes' poses, the odometry as far as the loops bear it out, and the loops that
// count in the end: plain least squares of them gives about the same poses. Empty without a polish.
PoseGraph FinalGraph(const LoopReport& report);

// A few lines: proposals, accepted, why others were not.
std::string LoopSummary(const LoopReport& report);

}  // namespace tvl
