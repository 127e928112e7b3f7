#include "tvl/eval/loop_evaluation.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Twice round a circle of 100 m, a keyframe a metre, 1 m/s: the second round is a revisit.
std::vector<TrueKeyframe> TwoRounds() {
  std::vector<TrueKeyframe> truth;
  for (int i = 0; i < 200; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / 100.0;
    Vector6d yaw = Vector6d::Zero();
    yaw[2] = angle;
    truth.push_back({Timestamp::FromSeconds(i), static_cast<double>(i),
                     Rigid3d::Translation(15.9 * std::sin(angle), 15.9 * (1 - std::cos(angle)), 0) *
                         Rigid3d::Exp(yaw)});
  }
  return truth;
}

LoopRecord Record(int history, int current, LoopProposer proposer, LoopOutcome outcome,
                  const std::vector<TrueKeyframe>& truth, double off_m) {
  LoopRecord record;
  record.proposal.history = history;
  record.proposal.current = current;
  record.proposal.proposer = proposer;
  record.outcome = outcome;
  record.verdict.T_history_current = truth[static_cast<size_t>(history)].T_world_lidar.Inverse() *
                                     truth[static_cast<size_t>(current)].T_world_lidar *
                                     Rigid3d::Translation(off_m, 0, 0);
  return record;
}

TEST(EvaluateLoops, CountsWhatIsRightWrongAndMissed) {
  const std::vector<TrueKeyframe> truth = TwoRounds();
  const auto kLidar = LoopProposer::kLidar, kVisual = LoopProposer::kVisual;
  const std::vector<LoopRecord> records = {
      Record(20, 120, kLidar, LoopOutcome::kAccepted, truth, 0.1),
      Record(20, 120, kVisual, LoopOutcome::kCovered, truth, 0.0),
      Record(21, 121, kLidar, LoopOutcome::kAccepted, truth, 0.3),
      Record(50, 130, kLidar, LoopOutcome::kRefused, truth, 0.0),    // 15 m or so apart
      Record(60, 140, kVisual, LoopOutcome::kAccepted, truth, 2.0),  // false
      Record(61, 141, kVisual, LoopOutcome::kDropped, truth, 2.0),   // false while it was in
      Record(62, 142, kVisual, LoopOutcome::kDropped, truth, 0.1)};
  const LoopEvaluation e = EvaluateLoops(records, truth);
  EXPECT_EQ(e.accepted, 3);
  EXPECT_EQ(e.false_accepted, 1);
  EXPECT_EQ(e.dropped, 2);
  EXPECT_EQ(e.false_dropped, 1);
  // Everything from about 10 m before the start on.
  EXPECT_NEAR(e.revisit_keyframes, 110, 2);
  EXPECT_EQ(e.closed_keyframes, 3);
  const ProposerScore& lidar = e.by_proposer[static_cast<size_t>(kLidar)];
  EXPECT_EQ(lidar.proposals, 3);
  EXPECT_EQ(lidar.at_revisits, 2);
  EXPECT_EQ(lidar.accepted, 2);
  EXPECT_EQ(lidar.keyframes_found, 2);
  EXPECT_NEAR(e.error_p50_m, 0.3, 1e-9);
  EXPECT_NEAR(e.error_p95_m, 2.0, 1e-9);
  EXPECT_NE(ToText(e).find("3 accepted, 1 false; 2 dropped in the end, 1 of them false"),
            std::string::npos);
}

TEST(EvaluateLoops, RefusesKeyframesItHasNoTruthFor) {
  const std::vector<TrueKeyframe> truth = TwoRounds();
  LoopRecord record = Record(0, 100, LoopProposer::kVicinity, LoopOutcome::kAccepted, truth, 0.0);
  record.proposal.current = 200;
  EXPECT_THROW(EvaluateLoops({record}, truth), Error);
}

}  // namespace
}  // namespace tvl
