#include "tvl/eval/loop_evaluation.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(std::llround(share * static_cast<double>(values.size() - 1)))];
}

const TrueKeyframe& At(const std::vector<TrueKeyframe>& truth, int keyframe) {
  TVL_CHECK(keyframe >= 0 && static_cast<size_t>(keyframe) < truth.size())
      << "loop evaluation: keyframe " << keyframe << " of " << truth.size();
  return truth[static_cast<size_t>(keyframe)];
}

// For each keyframe: does it see a place again?
std::vector<char> FindRevisits(const std::vector<TrueKeyframe>& truth,
                               const LoopEvaluationOptions& options) {
  std::vector<char> revisits(truth.size(), 0);
  for (size_t i = 0; i < truth.size(); ++i) {
    for (size_t j = 0; j < i && revisits[i] == 0; ++j) {
      if (SecondsBetween(truth[j].stamp, truth[i].stamp) <= options.min_time_s) break;
      if (truth[i].path_m - truth[j].path_m <= options.min_path_m) break;
      const Eigen::Vector3d apart = truth[i].T_world_lidar.t() - truth[j].T_world_lidar.t();
      revisits[i] = apart.norm() < options.revisit_m;
    }
  }
  return revisits;
}

}  // namespace

LoopError ErrorOf(const LoopRecord& record, const std::vector<TrueKeyframe>& truth) {
  const Rigid3d T_history_current = At(truth, record.proposal.history).T_world_lidar.Inverse() *
                                    At(truth, record.proposal.current).T_world_lidar;
  const Rigid3d error = T_history_current.Inverse() * record.verdict.T_history_current;
  return {error.t().norm(), error.RotationAngle(), T_history_current.t().norm()};
}

LoopEvaluation EvaluateLoops(const std::vector<LoopRecord>& records,
                             const std::vector<TrueKeyframe>& truth,
                             const LoopEvaluationOptions& options) {
  LoopEvaluation evaluation;
  const std::vector<char> revisits = FindRevisits(truth, options);
  std::array<std::set<int>, kLoopProposers> found;
  std::set<int> closed;
  std::vector<double> errors_m, errors_rad;
  for (const LoopRecord& record : records) {
    const auto proposer = static_cast<size_t>(record.proposal.proposer);
    ProposerScore& score = evaluation.by_proposer[proposer];
    const LoopError error = ErrorOf(record, truth);
    const bool is_revisit = error.true_distance_m < options.revisit_m;
    ++score.proposals;
    score.at_revisits += is_revisit;
    if (is_revisit) found[proposer].insert(record.proposal.current);
    const bool is_false =
        error.translation_m > options.false_m || error.rotation_rad > options.false_rad;
    if (record.outcome == LoopOutcome::kDropped) {
      ++evaluation.dropped;
      evaluation.false_dropped += is_false;
    }
    if (record.outcome != LoopOutcome::kAccepted) continue;
    ++score.accepted;
    ++evaluation.accepted;
    evaluation.false_accepted += is_false;
    errors_m.push_back(error.translation_m);
    errors_rad.push_back(error.rotation_rad);
    closed.insert(record.proposal.current);
  }
  for (size_t i = 0; i < truth.size(); ++i) {
    if (revisits[i] == 0) continue;
    ++evaluation.revisit_keyframes;
    evaluation.closed_keyframes += closed.count(static_cast<int>(i)) > 0;
    for (size_t p = 0; p < kLoopProposers; ++p) {
      evaluation.by_proposer[p].keyframes_found += found[p].count(static_cast<int>(i)) > 0;
    }
  }
  evaluation.error_p50_m = Percentile(errors_m, 0.5);
  evaluation.error_p95_m = Percentile(errors_m, 0.95);
  evaluation.error_p50_rad = Percentile(errors_rad, 0.5);
  evaluation.error_p95_rad = Percentile(errors_rad, 0.95);
  return evaluation;
}

std::string ToText(const LoopEvaluation& e) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(3);
  out << "loops against the truth: " << e.accepted << " accepted, " << e.false_accepted
      << " false; " << e.dropped << " dropped in the end, " << e.false_dropped << " of them false; "
      << e.closed_keyframes << " of " << e.revisit_keyframes
      << " revisiting keyframes closed; error p50 / p95 " << e.error_p50_m << " / " << e.error_p95_m
      << " m, " << RadToDeg(e.error_p50_rad) << " / " << RadToDeg(e.error_p95_rad) << " deg\n";
  for (int p = 0; p < kLoopProposers; ++p) {
    const ProposerScore& score = e.by_proposer[static_cast<size_t>(p)];
    out << "  " << std::left << std::setw(9) << ToString(static_cast<LoopProposer>(p))
        << score.proposals << " proposals, precision " << score.precision() << ", recall "
        << (e.revisit_keyframes > 0 ? double(score.keyframes_found) / e.revisit_keyframes : 0.0)
        << "\n";
  }
  return out.str();
}

}  // namespace tvl
