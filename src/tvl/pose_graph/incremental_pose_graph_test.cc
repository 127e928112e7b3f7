#include "tvl/pose_graph/incremental_pose_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/pose_graph/batch_pose_graph.h"
#include "tvl/pose_graph/synthetic_graph.h"
#include "tvl/pose_graph/test_graphs.h"

namespace tvl {
namespace {

// Thresholds so tight that the incremental solution is the least-squares one.
IncrementalPoseGraphOptions Exact() {
  IncrementalPoseGraphOptions options;
  options.loop_loss = LoopLoss::kNone;
  options.relinearize_rotation_rad = options.relinearize_translation_m = 1e-7;
  options.settle_rotation_rad = options.settle_translation_m = 0.0;
  options.max_iterations = 20;
  return options;
}

// Poses and loops in the order a drive would deliver them.
IncrementalPoseGraph Grown(const PoseGraph& graph, const IncrementalPoseGraphOptions& options) {
  IncrementalPoseGraph grown(options);
  grown.AddFirst(graph.T_world.front());
  for (const PoseConstraint& odometry : graph.odometry) {
    grown.AddKeyframe(odometry);
    std::vector<PoseConstraint> loops;
    for (const PoseConstraint& loop : graph.loops) {
      if (std::max(loop.from, loop.to) == odometry.to) loops.push_back(loop);
    }
    if (!loops.empty()) grown.AddLoops(loops);
  }
  return grown;
}

BatchPoseGraphResult LeastSquares(const PoseGraph& graph) {
  BatchPoseGraphOptions options;
  options.loop_loss = LoopLoss::kNone;
  options.min_cost_decrease = 1e-12;
  return OptimizeBatch(graph, options);
}

TEST(IncrementalPoseGraph, AgreesWithBatchOnRandomGraphs) {
  for (int seed = 0; seed < 25; ++seed) {
    Rng rng(seed, 1);
    const int poses = 2 + static_cast<int>(rng.Integer(120));
    const PoseGraph graph = RandomGraph(seed, poses, static_cast<int>(rng.Integer(40)));
    const IncrementalPoseGraph grown = Grown(graph, Exact());
    const BatchPoseGraphResult batch = LeastSquares(graph);
    ASSERT_TRUE(batch.converged) << seed;
    EXPECT_NEAR(grown.Cost(), batch.cost, 1e-6 * batch.cost + 1e-9) << seed;
    for (int k = 0; k < poses; ++k) {
      EXPECT_THAT(grown.estimates()[k], Rigid3dNear(batch.T_world[k], 1e-4, 1e-3)) << seed;
    }
  }
}

TEST(IncrementalPoseGraph, DefaultsStayCloseToBatchOnADrive) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  IncrementalPoseGraphOptions plain;
  plain.loop_loss = LoopLoss::kNone;
  const IncrementalPoseGraph grown = Grown(drive.graph, plain);
  const BatchPoseGraphResult batch = LeastSquares(drive.graph);
  EXPECT_LT(grown.Cost(), 1.001 * batch.cost);
  EXPECT_LT(AlignedRmse(grown.estimates(), batch.T_world), 0.01);
}

TEST(IncrementalPoseGraph, AKeyframeTouchesFewAndMovesNone) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  IncrementalPoseGraph graph{IncrementalPoseGraphOptions()};
  graph.AddFirst(drive.graph.T_world.front());
  size_t loop = 0;
  for (const PoseConstraint& odometry : drive.graph.odometry) {
    const std::vector<Rigid3d> before = graph.estimates();
    const PoseGraphUpdate update = graph.AddKeyframe(odometry);
    EXPECT_LT(update.eliminated, 30);
    EXPECT_EQ(update.relinearized, 0);
    const auto [a, b] = std::mismatch(
        before.begin(), before.end(), graph.estimates().begin(),
        [](const Rigid3d& x, const Rigid3d& y) { return (x.t() - y.t()).norm() == 0.0; });
    EXPECT_EQ(a, before.end());
    for (; loop < drive.graph.loops.size() && drive.graph.loops[loop].to == odometry.to; ++loop) {
      EXPECT_GT(graph.AddLoops({drive.graph.loops[loop]}).moved, 0);
    }
  }
}

TEST(IncrementalPoseGraph, RelativeCovarianceIsTheDenseInverse) {
  IncrementalPoseGraph grown = Grown(RandomGraph(4, 40, 10), Exact());
  const PoseGraph graph = grown.Graph();
  const Eigen::MatrixXd covariance = DenseInformation(graph).inverse();
  const auto block = [&](int i, int j) -> Matrix6d {
    if (i == 0 || j == 0) return Matrix6d::Zero();
    return covariance.block<6, 6>(6 * (i - 1), 6 * (j - 1));
  };
  for (const auto& [i, j] : std::vector<std::pair<int, int>>{
           {3, 30}, {30, 3}, {0, 17}, {17, 0}, {38, 39}, {5, 6}, {12, 12}}) {
    const Matrix6d A = -(graph.T_world[j].Inverse() * graph.T_world[i]).Adjoint();
    const Matrix6d cross = A * block(i, j);
    const Matrix6d expected =
        A * block(i, i) * A.transpose() + cross + cross.transpose() + block(j, j);
    const Matrix6d found = grown.RelativeCovariance(i, j);
    EXPECT_LT((found - expected).norm(), 1e-4 * expected.norm() + 1e-12) << i << " " << j;
  }
}

TEST(IncrementalPoseGraph, CovarianceOfAChainIsThatOfItsLinks) {
  const PoseGraph graph = RandomGraph(5, 10, 0);
  const IncrementalPoseGraph grown = Grown(graph, Exact());
  const Matrix6d last = graph.odometry.back().information.inverse();
  EXPECT_LT((grown.RelativeCovariance(8, 9) - last).norm(), 1e-9 * last.norm());
}

TEST(IncrementalPoseGraph, InnovationTellsTrueLoopsFromFalse) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  options.false_loops = 16;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  PoseGraph odometry = drive.graph;
  odometry.loops.clear();
  const IncrementalPoseGraph graph = Grown(odometry, IncrementalPoseGraphOptions());
  double sum = 0.0;
  for (size_t k = 0; k < drive.graph.loops.size(); ++k) {
    const double innovation_sq = graph.InnovationSq(drive.graph.loops[k]);
    if (drive.is_false_loop[k]) {
      EXPECT_GT(innovation_sq, 22.5);
    } else {
      sum += innovation_sq / 60.0;
    }
  }
  EXPECT_GT(sum, 4.0);  // 6 on average
  EXPECT_LT(sum, 8.0);
}

TEST(IncrementalPoseGraph, AFalseLoopIsLeftAlone) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  IncrementalPoseGraph graph = Grown(drive.graph, IncrementalPoseGraphOptions());
  const double clean_m = AlignedRmse(graph.estimates(), drive.truth);
  graph.AddLoops({{20, 700, Rigid3d::Translation(1, 2, 0), drive.graph.loops[0].information}});
  EXPECT_LT(graph.LoopWeights().back(), 0.1);
  EXPECT_LT(AlignedRmse(graph.estimates(), drive.truth), 1.1 * clean_m);
}

Matrix6d Information(double rotation_rad, double translation_m) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(rotation_rad), Eigen::Vector3d::Constant(translation_m);
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

PoseConstraint LoopAside(int from, int to, double aside_m) {
  return {from, to, Rigid3d::Translation(to - from, aside_m, 0), Information(0.003, 0.05)};
}

// Straight on for 200 m, with a first loop that is 1.5 m off: the drift still allows that.
IncrementalPoseGraph Deceived() {
  IncrementalPoseGraph graph{IncrementalPoseGraphOptions()};
  graph.AddFirst(Rigid3d());
  for (int k = 1; k <= 200; ++k) {
    graph.AddKeyframe({k - 1, k, Rigid3d::Translation(1, 0, 0), Information(0.002, 0.02)});
  }
  graph.AddLoops({LoopAside(0, 150, 1.5)});
  EXPECT_GT(graph.LoopWeights()[0], 0.9);
  EXPECT_NEAR(graph.estimates()[150].t().y(), 1.5, 0.1);
  return graph;
}

TEST(IncrementalPoseGraph, ALoopBelievedAtFirstIsGivenUpByTheBatchWhenOthersContradict) {
  IncrementalPoseGraph graph = Deceived();
  std::vector<PoseConstraint> loops;
  for (int k = 0; k < 4; ++k) {
    loops.push_back(LoopAside(0, 151 + k, 0.0));
  }
  graph.AddLoops(loops);
  EXPECT_GT(graph.LoopWeights()[0], 0.9);  // it came first, so the true ones wait
  for (int k = 1; k <= 4; ++k) EXPECT_EQ(graph.LoopWeights()[k], 0.0) << k;
  const BatchPoseGraphResult batch = OptimizeBatch(graph.Graph(), BatchPoseGraphOptions());
  EXPECT_LT(batch.loop_weights[0], 0.3);
  for (int k = 1; k <= 4; ++k) EXPECT_GT(batch.loop_weights[k], 0.9) << k;
  EXPECT_NEAR(batch.T_world[150].t().y(), 0.0, 0.1);
}

TEST(IncrementalPoseGraph, WeightsFollowTheEstimates) {
  // No loop is a surprise when it comes, but the first is left more and more alone.
  IncrementalPoseGraph graph = Deceived();
  for (const auto& [aside_m, count] :
       std::vector<std::pair<double, int>>{{1.38, 5}, {1.26, 10}, {1.18, 20}}) {
    for (int k = 0; k < count; ++k) graph.AddLoops({LoopAside(0, 150, aside_m)});
  }
  EXPECT_GT(graph.LoopWeights().back(), 0.9);
  EXPECT_LT(graph.LoopWeights()[0], 0.8);
}

TEST(IncrementalPoseGraph, SameInputSameBytes) {
  const PoseGraph graph = RandomGraph(6, 80, 30);
  const IncrementalPoseGraph a = Grown(graph, IncrementalPoseGraphOptions());
  const IncrementalPoseGraph b = Grown(graph, IncrementalPoseGraphOptions());
  for (int k = 0; k < a.size(); ++k) {
    EXPECT_TRUE(a.estimates()[k].Matrix() == b.estimates()[k].Matrix());
  }
}

TEST(IncrementalPoseGraph, MisuseIsNamed) {
  IncrementalPoseGraph graph{IncrementalPoseGraphOptions()};
  EXPECT_THROW(graph.AddKeyframe({0, 1, Rigid3d(), Matrix6d::Identity()}), Error);
  graph.AddFirst(Rigid3d());
  EXPECT_THROW(graph.AddFirst(Rigid3d()), Error);
  EXPECT_THROW(graph.AddKeyframe({0, 2, Rigid3d(), Matrix6d::Identity()}), Error);
  EXPECT_THROW(graph.AddKeyframe({0, 1, Rigid3d(), Matrix6d::Zero()}), InputError);
  EXPECT_EQ(graph.size(), 1);
  graph.AddKeyframe({0, 1, Rigid3d(), Matrix6d::Identity()});
  EXPECT_THROW(graph.AddLoops({{0, 5, Rigid3d(), Matrix6d::Identity()}}), InputError);
  EXPECT_EQ(graph.loops(), 0);
  IncrementalPoseGraphOptions options;
  options.settle_rotation_rad = 1.0;
  EXPECT_THROW(IncrementalPoseGraph{options}, InputError);
}

}  // namespace
}  // namespace tvl
