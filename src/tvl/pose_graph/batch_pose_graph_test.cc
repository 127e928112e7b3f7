#include "tvl/pose_graph/batch_pose_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/pose_graph/synthetic_graph.h"
#include "tvl/pose_graph/test_graphs.h"

namespace tvl {
namespace {

BatchPoseGraphOptions With(LoopLoss loss) {
  BatchPoseGraphOptions options;
  options.loop_loss = loss;
  return options;
}

SyntheticGraph Drive(int false_loops) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  options.false_loops = false_loops;
  return MakeSyntheticGraph(options);
}

PoseGraph WithoutFalseLoops(const SyntheticGraph& drive) {
  PoseGraph clean = drive.graph;
  clean.loops.clear();
  for (size_t k = 0; k < drive.graph.loops.size(); ++k) {
    if (!drive.is_false_loop[k]) clean.loops.push_back(drive.graph.loops[k]);
  }
  return clean;
}

TEST(BatchPoseGraph, FindsAMinimumAndHoldsTheFirstPose) {
  const PoseGraph graph = RandomGraph(1, 50, 15);
  const BatchPoseGraphResult result = OptimizeBatch(graph, With(LoopLoss::kNone));
  EXPECT_TRUE(result.converged);
  EXPECT_THAT(result.T_world[0], Rigid3dNear(graph.T_world[0], 1e-12, 1e-12));
  const auto cost = [&](const std::vector<Rigid3d>& T_world) {
    return PoseGraphCost(graph, T_world, LoopLoss::kNone, 1.0);
  };
  EXPECT_NEAR(result.cost, cost(result.T_world), 1e-9 * result.cost);
  Rng rng(2);
  for (int k = 1; k < 50; ++k) {
    std::vector<Rigid3d> other = result.T_world;
    other[k] = other[k] * RandomMotion(&rng, 1e-4, 1e-3);
    EXPECT_GT(cost(other), result.cost) << k;
  }
}

TEST(BatchPoseGraph, ExactMeasurementsGiveTheTruth) {
  SyntheticGraph drive = Drive(0);
  for (auto* constraints : {&drive.graph.odometry, &drive.graph.loops}) {
    for (PoseConstraint& c : *constraints) {
      c.T_from_to = drive.truth[c.from].Inverse() * drive.truth[c.to];
    }
  }
  const BatchPoseGraphResult result = OptimizeBatch(drive.graph, With(LoopLoss::kNone));
  for (size_t k = 0; k < drive.truth.size(); k += 50) {
    EXPECT_THAT(result.T_world[k], Rigid3dNear(drive.truth[k], 1e-6, 1e-4)) << k;
  }
}

void ExpectFalseLoopsFound(const SyntheticGraph& drive, double clean_m) {
  const BatchPoseGraphResult result = OptimizeBatch(drive.graph, With(LoopLoss::kDcs));
  EXPECT_LT(AlignedRmse(result.T_world, drive.truth), 1.1 * clean_m);
  for (size_t k = 0; k < drive.graph.loops.size(); ++k) {
    EXPECT_EQ(result.loop_weights[k] > 0.5, !drive.is_false_loop[k]) << "loop " << k;
  }
}

double CleanRmse(const SyntheticGraph& drive) {
  const auto clean = OptimizeBatch(WithoutFalseLoops(drive), With(LoopLoss::kNone));
  return AlignedRmse(clean.T_world, drive.truth);
}

TEST(BatchPoseGraph, AFifthOfTheLoopsMayBeFalse) {
  const SyntheticGraph drive = Drive(16);
  const double clean_m = CleanRmse(drive);
  ExpectFalseLoopsFound(drive, clean_m);
  // Without robust handling the same graph is ruined.
  const BatchPoseGraphResult naive = OptimizeBatch(drive.graph, With(LoopLoss::kNone));
  EXPECT_GT(AlignedRmse(naive.T_world, drive.truth), 10.0 * clean_m);
}

TEST(BatchPoseGraph, FalseLoopsAreFoundAfterMuchDrift) {
  // From the given poses alone every loop is doubted: 9 m of drift, loops good to 0.05 m.
  SyntheticGraphOptions options;
  options.false_loops = 75;
  options.odometry_rotation_rad = 1e-3;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  ExpectFalseLoopsFound(drive, CleanRmse(drive));
}

TEST(BatchPoseGraph, GraduatedTruncatedLossDropsFalseLoops) {
  const SyntheticGraph drive = Drive(16);
  const BatchPoseGraphResult result = OptimizeBatch(drive.graph, With(LoopLoss::kGnc));
  for (size_t k = 0; k < drive.graph.loops.size(); ++k) {
    if (drive.is_false_loop[k]) {
      EXPECT_EQ(result.loop_weights[k], 0.0);
    }
  }
}

TEST(BatchPoseGraph, LossesAreContinuousAndTheirWeightsTheirSlope) {
  for (const LoopLoss loss : {LoopLoss::kNone, LoopLoss::kHuber, LoopLoss::kDcs, LoopLoss::kGnc}) {
    for (const double e_sq : {0.5, 9.9, 10.1, 40.0, 1000.0}) {
      const double step = 1e-5 * e_sq;
      const double slope = (EvaluateLoopLoss(loss, e_sq + step, 10.0).rho -
                            EvaluateLoopLoss(loss, e_sq - step, 10.0).rho) /
                           (2.0 * step);
      EXPECT_NEAR(EvaluateLoopLoss(loss, e_sq, 10.0).weight, slope, 1e-6)
          << static_cast<int>(loss) << " " << e_sq;
    }
    EXPECT_NEAR(EvaluateLoopLoss(loss, 10.0 - 1e-9, 10.0).rho,
                EvaluateLoopLoss(loss, 10.0 + 1e-9, 10.0).rho, 1e-6);
  }
}

TEST(BatchPoseGraph, UnusableGraphsAreNamed) {
  PoseGraph graph = RandomGraph(1, 5, 0);
  graph.odometry.erase(graph.odometry.begin() + 2);  // poses 3 and 4 hang in the air
  EXPECT_THROW(OptimizeBatch(graph, With(LoopLoss::kNone)), Error);
  graph.odometry[0].to = 9;
  EXPECT_THROW(OptimizeBatch(graph, With(LoopLoss::kNone)), InputError);
  BatchPoseGraphOptions options;
  options.loop_width_sq = 0.0;
  EXPECT_THROW(OptimizeBatch(RandomGraph(1, 5, 0), options), InputError);
  EXPECT_EQ(OptimizeBatch({{Rigid3d()}, {}, {}}, With(LoopLoss::kDcs)).T_world.size(), 1U);
}

}  // namespace
}  // namespace tvl
