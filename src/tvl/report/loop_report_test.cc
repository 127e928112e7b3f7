#include "tvl/report/loop_report.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

// Four keyframes and three loops between them, of which the second was dropped.
LoopReport Report() {
  LoopReport report;
  for (int i = 0; i < 4; ++i) report.graph.T_world.push_back(Rigid3d::Translation(i, 0, 0));
  for (int i = 1; i < 4; ++i) {
    report.graph.odometry.push_back({i - 1, i, Rigid3d::Translation(1, 0, 0)});
  }
  const LoopOutcome outcomes[] = {LoopOutcome::kAccepted, LoopOutcome::kDropped,
                                  LoopOutcome::kAccepted};
  for (int i = 0; i < 3; ++i) {
    LoopRecord record;
    record.proposal.history = i / 2;
    record.proposal.current = 2 + i % 2;
    record.outcome = outcomes[i];
    report.records.push_back(record);
    report.graph.loops.push_back(
        {record.proposal.history, record.proposal.current, Rigid3d::Translation(2, 0, 0)});
  }
  report.odometry_variance_factor = 4.0;
  return report;
}

TEST(FinalGraph, HoldsWhatCountsInTheEnd) {
  const PoseGraph graph = FinalGraph(Report());
  EXPECT_EQ(graph.T_world.size(), 4u);
  ASSERT_EQ(graph.odometry.size(), 3u);
  EXPECT_TRUE(graph.odometry[0].information.isApprox(0.25 * Matrix6d::Identity()));
  ASSERT_EQ(graph.loops.size(), 2u);
  EXPECT_EQ(graph.loops[0].to, 2);
  EXPECT_EQ(graph.loops[1].from, 1);
  EXPECT_TRUE(graph.loops[1].information.isApprox(Matrix6d::Identity()));
  EXPECT_TRUE(FinalGraph(LoopReport()).T_world.empty());
}

TEST(LoopsToJson, SaysHowFarTheOdometryIsBelievedAndWhatWasDropped) {
  const std::vector<TrueKeyframe> truth(4);
  const nlohmann::json json = LoopsToJson(Report(), truth);
  EXPECT_EQ(json["odometry_variance_factor"], 4.0);
  EXPECT_EQ(json["against_truth"]["accepted"], 2);
  EXPECT_EQ(json["against_truth"]["dropped"], 1);
  EXPECT_EQ(json["against_truth"]["false_dropped"], 0);
}

}  // namespace
}  // namespace tvl
