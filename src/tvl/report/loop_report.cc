#include "tvl/report/loop_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>

#include "tvl/base/units.h"
#include "tvl/slam/loop_support.h"

namespace tvl {
namespace {

using nlohmann::json;

// CSV as RFC 4180 has it.
std::string Quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string Status(const LoopRecord& record) {
  const bool is_verified =
      record.outcome != LoopOutcome::kCovered && record.outcome != LoopOutcome::kNotVerified;
  return is_verified ? ToString(record.verdict.status) : "";
}

struct Stage {
  const char* name;
  double LoopTimes::*ms;
};
constexpr Stage kStages[] = {{"describe", &LoopTimes::describe_ms},
                             {"propose_visual", &LoopTimes::propose_visual_ms},
                             {"propose_vicinity", &LoopTimes::propose_vicinity_ms},
                             {"propose_lidar", &LoopTimes::propose_lidar_ms},
                             {"verify", &LoopTimes::verify_ms},
                             {"graph", &LoopTimes::graph_ms},
                             {"total", &LoopTimes::total_ms}};

json TimesToJson(const LoopReport& report) {
  json out = {{"second_look_ms", report.second_look_ms}, {"polish_ms", report.polish_ms}};
  for (const Stage& stage : kStages) {
    std::vector<double> ms;
    for (const LoopTimes& times : report.times) ms.push_back(times.*stage.ms);
    if (ms.empty()) continue;
    std::sort(ms.begin(), ms.end());
    double sum = 0.0;
    for (const double v : ms) sum += v;
    const auto at = [&](double share) {
      return ms[static_cast<size_t>(std::llround(share * static_cast<double>(ms.size() - 1)))];
    };
    out[stage.name] = {{"mean_ms", sum / static_cast<double>(ms.size())},
                       {"p50_ms", at(0.5)},
                       {"p95_ms", at(0.95)},
                       {"max_ms", ms.back()}};
  }
  return out;
}

json EvaluationToJson(const LoopEvaluation& e) {
  json out = {{"revisit_keyframes", e.revisit_keyframes},
              {"closed_keyframes", e.closed_keyframes},
              {"recall", e.recall()},
              {"accepted", e.accepted},
              {"false_accepted", e.false_accepted},
              {"dropped", e.dropped},
              {"false_dropped", e.false_dropped},
              {"error_p50_m", e.error_p50_m},
              {"error_p95_m", e.error_p95_m},
              {"error_p50_deg", RadToDeg(e.error_p50_rad)},
              {"error_p95_deg", RadToDeg(e.error_p95_rad)}};
  for (int p = 0; p < kLoopProposers; ++p) {
    const ProposerScore& score = e.by_proposer[static_cast<size_t>(p)];
    out["by_proposer"][ToString(static_cast<LoopProposer>(p))] = {
        {"proposals", score.proposals},
        {"at_revisits", score.at_revisits},
        {"accepted", score.accepted},
        {"precision", score.precision()},
        {"recall", e.revisit_keyframes > 0
                       ? static_cast<double>(score.keyframes_found) / e.revisit_keyframes
                       : 0.0}};
  }
  return out;
}

void WriteRow(const LoopRecord& record, const std::vector<TrueKeyframe>& truth, std::ostream& out) {
  const LoopProposal& proposal = record.proposal;
  const LoopVerdict& verdict = record.verdict;
  const Vector6d T = verdict.T_history_current.Log();
  out << proposal.current << "," << proposal.history << "," << record.current_frame << ","
      << record.history_frame << "," << ToString(proposal.proposer) << "," << proposal.score << ","
      << proposal.matches << "," << ToString(record.outcome) << "," << Status(record) << ","
      << Quoted(record.reason) << "," << verdict.rms_m << "," << verdict.raised_rms_m << ","
      << verdict.overlap << "," << verdict.seen_through << "," << verdict.ambiguity << ","
      << record.chi2 << "," << record.linked_path_m << "," << record.weight << ","
      << (record.is_second_look ? 1 : 0);
  for (int i = 0; i < 6; ++i) out << "," << T[i];
  if (!truth.empty()) {
    const LoopError error = ErrorOf(record, truth);
    out << "," << error.true_distance_m << "," << error.translation_m << ","
        << RadToDeg(error.rotation_rad);
  }
  out << "\n";
}

}  // namespace

std::string LoopTable(const LoopReport& report, const std::vector<TrueKeyframe>& truth) {
  std::ostringstream out;
  out << std::setprecision(6);
  out << "current_keyframe,history_keyframe,current_frame,history_frame,proposer,score,matches,"
         "outcome,verdict,reason,rms_m,raised_rms_m,overlap,seen_through,ambiguity,chi2,"
         "linked_path_m,weight,second_look,log_rx_rad,log_ry_rad,log_rz_rad,log_x_m,log_y_m,"
         "log_z_m";
  out << (truth.empty() ? "\n" : ",true_distance_m,error_m,error_deg\n");
  for (const LoopRecord& record : report.records) WriteRow(record, truth, out);
  return out.str();
}

json LoopsToJson(const LoopReport& report, const std::vector<TrueKeyframe>& truth) {
  json counts = json::object();
  for (const LoopRecord& record : report.records) {
    json& count = counts[ToString(record.proposal.proposer)][ToString(record.outcome)];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  json out = {{"proposals", report.records.size()},
              {"odometry_variance_factor", report.odometry_variance_factor},
              {"outcomes_by_proposer", counts},
              {"timing_per_keyframe", TimesToJson(report)}};
  if (!truth.empty()) {
    out["against_truth"] = EvaluationToJson(EvaluateLoops(report.records, truth));
  }
  return out;
}

PoseGraph FinalGraph(const LoopReport& report) {
  std::set<std::pair<int, int>> dropped;
  for (const LoopRecord& record : report.records) {
    if (record.outcome != LoopOutcome::kDropped) continue;
    dropped.emplace(record.proposal.history, record.proposal.current);
  }
  PoseGraph graph = WithOdometryVariance(report.graph, report.odometry_variance_factor);
  const auto is_dropped = [&](const PoseConstraint& loop) {
    return dropped.count({loop.from, loop.to}) > 0;
  };
  graph.loops.erase(std::remove_if(graph.loops.begin(), graph.loops.end(), is_dropped),
                    graph.loops.end());
  return graph;
}

std::string LoopSummary(const LoopReport& report) {
  std::map<LoopProposer, int> accepted;
  std::map<std::string, int> others;
  int all = 0;
  for (const LoopRecord& record : report.records) {
    if (record.outcome == LoopOutcome::kAccepted) {
      ++accepted[record.proposal.proposer];
      ++all;
    } else if (record.outcome != LoopOutcome::kCovered) {
      const bool is_refused = record.outcome == LoopOutcome::kRefused;
      ++others[is_refused ? ToString(record.verdict.status) : ToString(record.outcome)];
    }
  }
  std::ostringstream out;
  out << "loops: " << report.records.size() << " proposals, " << all << " accepted";
  for (const auto& [proposer, count] : accepted) {
    out << (proposer == accepted.begin()->first ? " (" : ", ") << ToString(proposer) << " "
        << count;
  }
  out << (accepted.empty() ? "" : ")");
  for (const auto& [why, count] : others) {
    out << (why == others.begin()->first ? "; not: " : ", ") << why << " " << count;
  }
  out << "\n";
  return out.str();
}

}  // namespace tvl
