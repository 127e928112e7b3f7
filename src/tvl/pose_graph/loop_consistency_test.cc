#include "tvl/pose_graph/loop_consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/pose_graph/synthetic_graph.h"
#include "tvl/pose_graph/test_graphs.h"

namespace tvl {
namespace {

OdometryChain ChainOf(const PoseGraph& graph) {
  OdometryChain chain;
  for (const PoseConstraint& c : graph.odometry) chain.Add(c);
  return chain;
}

TEST(LoopConsistency, ChainGivesPosesAndCovariancesOfTheirInverse) {
  const PoseGraph graph = RandomGraph(2, 30, 0);
  const OdometryChain chain = ChainOf(graph);
  const Eigen::MatrixXd covariance = DenseInformation(graph).inverse();
  const OdometryChain::Relative from_first = chain.Between(0, 20);
  EXPECT_THAT(from_first.T_i_j,
              Rigid3dNear(graph.T_world[0].Inverse() * graph.T_world[20], 1e-12, 1e-12));
  const Matrix6d expected = covariance.block<6, 6>(6 * 19, 6 * 19);
  EXPECT_LT((from_first.covariance - expected).norm(), 1e-6 * expected.norm());
  // Backwards: the same uncertainty, seen from the other end.
  const OdometryChain::Relative back = chain.Between(20, 0);
  const Matrix6d ad = from_first.T_i_j.Adjoint();
  EXPECT_LT((back.covariance - ad * expected * ad.transpose()).norm(), 1e-6 * expected.norm());
  EXPECT_THROW(OdometryChain().Add({0, 2, Rigid3d(), Matrix6d::Identity()}), Error);
}

TEST(LoopConsistency, CyclesOfTrueLoopsCloseWithinTheirUncertainty) {
  double sum = 0.0;
  int count = 0;
  for (int seed = 0; seed < 40; ++seed) {
    // White noise of just the information claimed.
    Rng rng(seed);
    PoseGraph graph = RandomGraph(seed, 40, 0);
    std::vector<Rigid3d> truth = graph.T_world;
    OdometryChain chain;
    for (PoseConstraint& c : graph.odometry) {
      c.information = RandomInformation(&rng, 1e-5, 1e-4);
      Vector6d white;
      for (int i = 0; i < 6; ++i) white[i] = rng.Normal();
      const Eigen::LLT<Matrix6d> llt(c.information);
      c.T_from_to = c.T_from_to * Rigid3d::Exp(Vector6d(llt.matrixU().solve(white)));
      chain.Add(c);
    }
    const PoseConstraint a{2, 33, truth[2].Inverse() * truth[33], 1e14 * Matrix6d::Identity()};
    const PoseConstraint b{9, 28, truth[9].Inverse() * truth[28], 1e14 * Matrix6d::Identity()};
    const PoseConstraint reverse{35, 5, truth[35].Inverse() * truth[5],
                                 1e14 * Matrix6d::Identity()};
    for (const double error_sq : {CycleErrorSq(chain, a, b), CycleErrorSq(chain, a, reverse)}) {
      sum += error_sq;
      ++count;
    }
    EXPECT_NEAR(CycleErrorSq(chain, a, b), CycleErrorSq(chain, b, a),
                0.1 * CycleErrorSq(chain, a, b));
  }
  EXPECT_NEAR(sum / count, 6.0, 1.2);
}

TEST(LoopConsistency, TheSetHoldsTrueLoopsOnly) {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  options.false_loops = 16;
  const SyntheticGraph drive = MakeSyntheticGraph(options);
  const std::vector<int> set = ConsistentSet(ChainOf(drive.graph), drive.graph.loops, 16.8);
  EXPECT_GE(set.size(), 45U);
  EXPECT_TRUE(std::is_sorted(set.begin(), set.end()));
  for (const int loop : set) EXPECT_FALSE(drive.is_false_loop[loop]) << loop;
}

TEST(LoopConsistency, NoLoopsNoSet) {
  EXPECT_TRUE(ConsistentSet(OdometryChain(), {}, 1.0).empty());
}

}  // namespace
}  // namespace tvl
