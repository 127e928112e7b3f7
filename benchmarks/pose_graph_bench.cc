// One synthetic pose graph, solved in all ways; prints JSON. Called by pose_graph.py.
// Times are processor time: other programs on the machine do not disturb them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tvl/base/index.h"
#include "tvl/io/g2o.h"
#include "tvl/pose_graph/batch_pose_graph.h"
#include "tvl/pose_graph/incremental_pose_graph.h"
#include "tvl/pose_graph/loop_consistency.h"
#include "tvl/pose_graph/synthetic_graph.h"

namespace {

using namespace tvl;  // NOLINT(google-build-using-namespace)
using nlohmann::json;

constexpr double kWidthSq = 16.8;

class ProcessorTime {
 public:
  double Ms() const { return 1e3 * static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

struct Grown {
  IncrementalPoseGraph graph;
  json report;
};

// The loops of the graph that the drive has reached with pose `to`.
std::vector<PoseConstraint> LoopsTo(int to, const PoseGraph& graph, size_t* next) {
  std::vector<PoseConstraint> loops;
  for (; *next < graph.loops.size() && graph.loops[*next].to == to; ++*next) {
    loops.push_back(graph.loops[*next]);
  }
  return loops;
}

json Report(const PoseGraphUpdate& update, double ms) {
  return {{"ms", ms},
          {"eliminated", update.eliminated},
          {"relinearized", update.relinearized},
          {"iterations", update.iterations}};
}

// As a drive would: each keyframe, then its loops.
Grown Grow(const PoseGraph& graph, LoopLoss loss) {
  IncrementalPoseGraphOptions options;
  options.loop_loss = loss;
  Grown grown{IncrementalPoseGraph(options),
              {{"keyframes", json::array()}, {"loops", json::array()}}};
  grown.graph.AddFirst(graph.T_world.front());
  size_t next = 0;
  for (const PoseConstraint& odometry : graph.odometry) {
    const ProcessorTime keyframe_time;
    const PoseGraphUpdate keyframe = grown.graph.AddKeyframe(odometry);
    grown.report["keyframes"].push_back(Report(keyframe, keyframe_time.Ms()));
    const std::vector<PoseConstraint> loops = LoopsTo(odometry.to, graph, &next);
    if (loops.empty()) continue;
    const ProcessorTime loop_time;
    const PoseGraphUpdate update = grown.graph.AddLoops(loops);
    grown.report["loops"].push_back(Report(update, loop_time.Ms()));
  }
  return grown;
}

BatchPoseGraphResult Batch(const PoseGraph& graph, LoopLoss loss) {
  BatchPoseGraphOptions options;
  options.loop_loss = loss;
  return OptimizeBatch(graph, options);
}

// Times and costs of plain least squares, for comparison with other solvers.
json LeastSquares(const SyntheticGraph& drive) {
  Grown grown = Grow(drive.graph, LoopLoss::kNone);
  const ProcessorTime batch_time;
  const BatchPoseGraphResult batch = Batch(drive.graph, LoopLoss::kNone);
  const double batch_ms = batch_time.Ms();
  const ProcessorTime polish_time;
  const BatchPoseGraphResult polished = Batch(grown.graph.Graph(), LoopLoss::kNone);
  json report = grown.report;
  report["polish_ms"] = polish_time.Ms();
  report["batch_ms"] = batch_ms;
  report["batch_iterations"] = batch.iterations;
  report["cost"] = {
      {"incremental", grown.graph.Cost()}, {"polished", polished.cost}, {"batch", batch.cost}};
  report["ate_m"] = {{"odometry", AlignedRmse(drive.graph.T_world, drive.truth)},
                     {"incremental", AlignedRmse(grown.graph.estimates(), drive.truth)},
                     {"batch", AlignedRmse(batch.T_world, drive.truth)}};
  return report;
}

PoseGraph OnlyLoops(const PoseGraph& graph, const std::vector<int>& loops) {
  PoseGraph result{graph.T_world, graph.odometry, {}};
  for (const int loop : loops) result.loops.push_back(graph.loops[Index(loop)]);
  return result;
}

json Verdict(const SyntheticGraph& drive, const std::vector<Rigid3d>& T_world,
             const std::vector<double>& weights, double ms) {
  int false_kept = 0, true_lost = 0;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (drive.is_false_loop[k] && weights[k] > 0.5) ++false_kept;
    if (!drive.is_false_loop[k] && weights[k] <= 0.5) ++true_lost;
  }
  return {{"ate_m", AlignedRmse(T_world, drive.truth)},
          {"false_kept", false_kept},
          {"true_lost", true_lost},
          {"ms", ms}};
}

// What each way of handling false loops makes of the graph.
json Robustness(const SyntheticGraph& drive) {
  json report;
  std::vector<int> true_loops;
  for (size_t k = 0; k < drive.graph.loops.size(); ++k) {
    if (!drive.is_false_loop[k]) true_loops.push_back(static_cast<int>(k));
  }
  const auto clean = Batch(OnlyLoops(drive.graph, true_loops), LoopLoss::kNone);
  report["clean"] = Verdict(drive, clean.T_world, {}, 0.0);
  const std::vector<std::pair<const char*, LoopLoss>> losses = {
      {"least squares", LoopLoss::kNone},
      {"huber", LoopLoss::kHuber},
      {"gnc", LoopLoss::kGnc},
      {"dcs, two starts", LoopLoss::kDcs}};
  for (const auto& [name, loss] : losses) {
    const ProcessorTime time;
    const BatchPoseGraphResult result = Batch(drive.graph, loss);
    report[name] = Verdict(drive, result.T_world, result.loop_weights, time.Ms());
  }
  const ProcessorTime set_time;
  OdometryChain chain;
  for (const PoseConstraint& c : drive.graph.odometry) chain.Add(c);
  const std::vector<int> set = ConsistentSet(chain, drive.graph.loops, kWidthSq);
  std::vector<double> in_set(drive.graph.loops.size(), 0.0);
  for (const int loop : set) in_set[Index(loop)] = 1.0;
  const auto agreed = Batch(OnlyLoops(drive.graph, set), LoopLoss::kNone);
  report["consistent set"] = Verdict(drive, agreed.T_world, in_set, set_time.Ms());
  const ProcessorTime time;
  const Grown grown = Grow(drive.graph, LoopLoss::kDcs);
  const double ms = time.Ms();
  json& ours = report["incremental dcs"];
  ours = Verdict(drive, grown.graph.estimates(), grown.graph.LoopWeights(), ms);
  double loop_ms_max = 0.0;
  for (const json& loop : grown.report["loops"]) {
    loop_ms_max = std::max(loop_ms_max, loop["ms"].get<double>());
  }
  ours["loop_ms_max"] = loop_ms_max;
  return report;
}

int Run(int argc, char** argv) {
  CLI::App app("Solves one synthetic pose graph in all ways and prints JSON");
  SyntheticGraphOptions options;
  std::string g2o, truth;
  app.add_option("--poses", options.poses);
  app.add_option("--loops", options.loops);
  app.add_option("--false-loops", options.false_loops);
  app.add_option("--seed", options.seed);
  app.add_option("--rotation-noise", options.odometry_rotation_rad, "rad a metre");
  app.add_option("--g2o", g2o, "write the graph here");
  app.add_option("--truth", truth, "write the true poses here, as g2o");
  CLI11_PARSE(app, argc, argv);
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  if (!g2o.empty()) WriteG2o(g2o, drive.graph);
  if (!truth.empty()) WriteG2o(truth, {drive.truth, {}, {}});
  const json report = options.false_loops > 0 ? Robustness(drive) : LeastSquares(drive);
  std::cout << report.dump(1) << "\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what() << "\n";
    return 1;
  }
}
