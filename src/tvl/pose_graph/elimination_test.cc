#include "tvl/pose_graph/elimination.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <set>

#include "tvl/base/rng.h"
#include "tvl/pose_graph/dense_elimination.h"

namespace tvl {
namespace {

VariableGroups RandomGroups(Rng* rng, int size) {
  VariableGroups groups;
  for (int k = 1; k < size; ++k) {
    groups.Add(k - 1);
    groups.Add(k);
    groups.Close();
    if (rng->Uniform() < 0.2) {
      for (int n = 0; n < 3; ++n) groups.Add(static_cast<int>(rng->Integer(size)));
      groups.Close();
    }
  }
  return groups;
}

TEST(Elimination, OrderIsAPermutationWithTheNewestLast) {
  Rng rng(1);
  std::vector<int> order = EliminationOrder(40, RandomGroups(&rng, 40), {7, 39});
  EXPECT_EQ(order[38], 7);
  EXPECT_EQ(order[39], 39);
  std::sort(order.begin(), order.end());
  for (int k = 0; k < 40; ++k) EXPECT_EQ(order[k], k);
}

TEST(Elimination, OrderKeepsTheFillSmall) {
  // A ladder: two parallel chains with rungs. By number the fill is as wide as the chain is long.
  VariableGroups groups;
  const auto link = [&](int a, int b) {
    groups.Add(a);
    groups.Add(b);
    groups.Close();
  };
  for (int k = 0; k < 200; ++k) {
    if (k > 0) link(k - 1, k);
    if (k > 0) link(200 + k - 1, 200 + k);
    link(k, 200 + k);
  }
  for (const SymbolicClique& clique :
       EliminateSymbolically(groups, EliminationOrder(400, groups, {}), 0)) {
    EXPECT_LE(clique.variables.size(), 8U);
  }
}

TEST(Elimination, CliquesHoldEveryGroupAndLeadToARoot) {
  for (const int slack : {0, 2}) {
    Rng rng(3);
    const VariableGroups groups = RandomGroups(&rng, 60);
    const auto cliques = EliminateSymbolically(groups, EliminationOrder(60, groups, {59}), slack);
    std::vector<int> home(60, -1);
    for (size_t c = 0; c < cliques.size(); ++c) {
      for (int k = 0; k < cliques[c].frontals; ++k) {
        EXPECT_EQ(home[cliques[c].variables[k]], -1);
        home[cliques[c].variables[k]] = static_cast<int>(c);
      }
      EXPECT_LT(cliques[c].parent, static_cast<int>(c));
    }
    EXPECT_EQ(home[59], 0);
    for (const SymbolicClique& clique : cliques) {
      // The whole separator lies in the parent.
      if (clique.parent < 0) continue;
      const auto& above = cliques[clique.parent].variables;
      for (size_t k = clique.frontals; k < clique.variables.size(); ++k) {
        EXPECT_THAT(above, testing::Contains(clique.variables[k]));
      }
    }
    int begin = 0;
    for (const int end : groups.ends) {  // each group fits into the clique eliminated first
      int first = 0;
      for (int m = begin; m < end; ++m) first = std::max(first, home[groups.members[m]]);
      for (int m = begin; m < end; ++m) {
        EXPECT_THAT(cliques[first].variables, testing::Contains(groups.members[m]));
      }
      begin = end;
    }
  }
}

TEST(DenseElimination, IsTheCholeskyFactorAndTheSchurComplement) {
  Rng rng(4);
  Eigen::MatrixXd root(24, 24);
  for (Eigen::Index k = 0; k < root.size(); ++k) root(k) = rng.Normal();
  const Eigen::MatrixXd H = root * root.transpose() + Eigen::MatrixXd::Identity(24, 24);
  Eigen::MatrixXd front(25, 24);
  front.topRows(24) = H;
  for (int k = 0; k < 24; ++k) front(24, k) = rng.Normal();
  const Eigen::RowVectorXd rhs = front.row(24);
  ASSERT_TRUE(EliminateBlocks(2, &front));
  const Eigen::MatrixXd A = H.topLeftCorner(12, 12), B = H.bottomLeftCorner(12, 12);
  const Eigen::MatrixXd L = Eigen::LLT<Eigen::MatrixXd>(A).matrixL();
  EXPECT_LT(
      (Eigen::MatrixXd(front.topLeftCorner(12, 12).triangularView<Eigen::Lower>()) - L).norm(),
      1e-9);
  const Eigen::MatrixXd schur = H.bottomRightCorner(12, 12) - B * A.inverse() * B.transpose();
  const Eigen::MatrixXd left = front.block(12, 12, 12, 12).triangularView<Eigen::Lower>();
  EXPECT_LT((left - Eigen::MatrixXd(schur.triangularView<Eigen::Lower>())).norm(), 1e-8);
  const Eigen::RowVectorXd left_rhs = rhs.tail(12) - rhs.head(12) * A.inverse() * B.transpose();
  EXPECT_LT((front.bottomRightCorner(1, 12) - left_rhs).norm(), 1e-8);
}

TEST(DenseElimination, IndefiniteAndBrokenFrontsAreRefused) {
  Eigen::MatrixXd front = Eigen::MatrixXd::Identity(7, 6);
  front(3, 3) = -1.0;
  EXPECT_FALSE(EliminateBlocks(1, &front));
  front = Eigen::MatrixXd::Identity(7, 6);
  front(3, 3) = std::nan("");
  EXPECT_FALSE(EliminateBlocks(1, &front));
}

}  // namespace
}  // namespace tvl
