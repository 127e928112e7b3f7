#include "tvl/slam/loop_closer.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/slam/test_forth_and_back.h"

namespace tvl {
namespace {

using synthetic::CountOf;
using synthetic::ForthAndBack;
using synthetic::RandomHouses;
using synthetic::SlowDrift;

TEST(LoopCloser, BringsADriftedReturnHome) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  const auto& keyframes = drive.keyframes();
  ASSERT_EQ(update.T_world_lidar.size(), keyframes.size());
  const double before_m =
      drive.EndError_m(keyframes.front().T_odom_lidar, keyframes.back().T_odom_lidar);
  EXPECT_GT(before_m, 0.5);
  EXPECT_LT(drive.EndError_m(update.T_world_lidar.front(), update.T_world_lidar.back()), 0.15);
  EXPECT_GE(CountOf(LoopOutcome::kAccepted, closer.report()), 10);
  for (const LoopRecord& record : closer.report().records) {
    if (record.outcome != LoopOutcome::kAccepted) continue;
    EXPECT_LT(drive.LoopError_m(record), 0.1);
  }
}

TEST(LoopCloser, KeepsTheFirstPoseAndReportsEveryKeyframe) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_LT((update.T_world_lidar.front().t() - drive.keyframes().front().T_odom_lidar.t()).norm(),
            1e-9);
  EXPECT_EQ(closer.report().times.size(), drive.keyframes().size());
  EXPECT_EQ(closer.report().graph.odometry.size() + 1, drive.keyframes().size());
  EXPECT_EQ(static_cast<int>(closer.report().graph.loops.size()),
            CountOf(LoopOutcome::kAccepted, closer.report()));
}

TEST(LoopCloser, RefusesAStreetThatOnlyLiesThere) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(2), SlowDrift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_GT(closer.report().records.size(), 10U);
  EXPECT_EQ(CountOf(LoopOutcome::kAccepted, closer.report()), 0);
  EXPECT_TRUE(update.T_world_lidar.empty());  // the odometry stands
}

TEST(LoopCloser, ProposersCanBeLeftOut) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Rigid3d());
  LoopOptions options;
  options.use_vicinity = false;
  LoopCloser lidar_only = drive.MakeCloser(options);
  drive.Run(&lidar_only);
  EXPECT_GT(CountOf(LoopOutcome::kAccepted, lidar_only.report()), 0);
  for (const LoopRecord& record : lidar_only.report().records) {
    EXPECT_EQ(record.proposal.proposer, LoopProposer::kLidar);
  }
  options.use_lidar = false;
  LoopCloser none = drive.MakeCloser(options);
  drive.Run(&none);
  EXPECT_TRUE(none.report().records.empty());
}

TEST(LoopCloser, ALoopTheGraphContradictsStaysOut) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopOptions options;
  options.consistency.max_chi2 = options.consistency.max_chi2_of_rows = 1e-6;
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_EQ(CountOf(LoopOutcome::kAccepted, closer.report()), 0);
  EXPECT_EQ(closer.report().records.back().outcome, LoopOutcome::kInconsistent);
}

TEST(LoopCloser, ARowThatAgreesIsBelievedAgainstTheGraph) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift(), 0.4);
  LoopOptions options;
  options.consistency.drift_floor_m = options.consistency.drift_share = 0.0;
  options.consistency.drift_rad_per_m = 0.0;  // and so the graph contradicts all of them
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_GE(CountOf(LoopOutcome::kAccepted, closer.report()), 10);
  options.consistency.min_row_m = 100.0;  // longer than the street
  LoopCloser strict = drive.MakeCloser(options);
  drive.Run(&strict);
  EXPECT_EQ(CountOf(LoopOutcome::kAccepted, strict.report()), 0);
}

TEST(LoopCloser, OdometryMuchWorseThanItThinksLosesNoTrueLoop) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift(), 0.01);
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_GT(closer.report().odometry_variance_factor, 10.0);
  for (const LoopRecord& record : closer.report().records) {
    EXPECT_NE(record.outcome, LoopOutcome::kDropped) << record.proposal.current;
  }
  EXPECT_LT(drive.EndError_m(update.T_world_lidar.front(), update.T_world_lidar.back()), 0.15);
}

TEST(LoopCloser, OneLoopAloneIsNotBelieved) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopOptions options;
  options.consistency.min_support = 1000;
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_EQ(CountOf(LoopOutcome::kAccepted, closer.report()), 0);
}

TEST(LoopCloser, IsTheSameToTheBit) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopCloser a = drive.MakeCloser(), b = drive.MakeCloser();
  const LoopUpdate first = drive.Run(&a), second = drive.Run(&b);
  for (size_t k = 0; k < first.T_world_lidar.size(); ++k) {
    EXPECT_EQ(first.T_world_lidar[k].t(), second.T_world_lidar[k].t());
  }
}

TEST(LoopCloser, RefusesKeyframesOutOfTurn) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopCloser closer = drive.MakeCloser();
  EXPECT_THROW(closer.Process(drive.keyframes()[1], KeyframePayload()), Error);
}

TEST(LoopOptions, NameTheBadField) {
  LoopOptions options;
  options.consistency.max_chi2 = 0.0;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("loops.consistency.max_chi2"), std::string::npos);
  }
}

}  // namespace
}  // namespace tvl
