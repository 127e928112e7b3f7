// run.json: everything worth knowing about a run, for people and programs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tvl/eval/loop_evaluation.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {

// What the program knows of a run besides its result.
struct RunContext {
  std::string version;
  std::string input;
  SensorSetup setup;
  std::string options_yaml;  // resolved, as in resolved.yaml
  int threads = 1;
  double wall_s = 0.0;
  double peak_memory_mib = 0.0;
  std::vector<TrueKeyframe> truth;  // one a keyframe; empty: not known
};

// Units are in the keys. Per frame: status, evidence, weak directions and `step_covariance`, the
// covariance of T_{k-1,k} in the body frame, right perturbation, [rotation (rad), translation (m)],
// 36 numbers, row-major. `extrinsics`: what the camera's rotation was found to be off by, about its
// axes x (right), y (down), z (forward), and what of it was used. Expected failures are counted
// under `counts`.
nlohmann::json MakeRunReport(const RunResult& result, const RunContext& context);

// Where the camera was found to point, in words, one line each; empty where nothing was corrected.
std::string ExtrinsicsText(const ExtrinsicEstimate& estimate);

// Milliseconds a frame by stage and in the grouping of the paper's Table 2, as a small table.
std::string TimingTable(const RunResult& result);

}  // namespace tvl
