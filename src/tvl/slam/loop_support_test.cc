#include "tvl/slam/loop_support.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

constexpr int kRound = 100;

Matrix6d Information(double sigma_rad, double sigma_m) {
  Matrix6d information = Matrix6d::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  information.diagonal().tail<3>().setConstant(1.0 / (sigma_m * sigma_m));
  return information;
}

// Twice round the same circle of 100 m.
struct TwoRounds {
  OdometryChain odometry;
  std::vector<double> path_m = {0.0};
  Rigid3d T_prev_cur;

  TwoRounds() {
    Vector6d step = Vector6d::Zero();
    step[2] = 2.0 * 3.14159265358979 / kRound;
    step[3] = 1.0;
    T_prev_cur = Rigid3d::Exp(step);
    for (int k = 1; k < 2 * kRound; ++k) {
      odometry.Add({k - 1, k, T_prev_cur, Information(1e-4, 0.003)});
      path_m.push_back(k);
    }
  }
  // Measured exactly but for a shift.
  static PoseConstraint Loop(int history, int current, double shift_m) {
    Vector6d back = Vector6d::Zero();
    const double turn = (current - history - kRound) * 2.0 * 3.14159265358979 / kRound;
    back[2] = turn;
    back[3] = current - history - kRound;
    return {history, current, Rigid3d::Translation(0, shift_m, 0) * Rigid3d::Exp(back),
            Information(0.002, 0.03)};
  }
};

TEST(FindSupport, TakesLoopsThatAgreeAndLieApart) {
  const TwoRounds drive;
  const std::vector<PoseConstraint> others = {
      TwoRounds::Loop(10, 110, 0.02),  // agrees
      TwoRounds::Loop(10, 110, 0.0),   // the same keyframe again
      TwoRounds::Loop(12, 112, 5.0),   // elsewhere
      TwoRounds::Loop(14, 114, 0.0),   // agrees
      TwoRounds::Loop(80, 180, 0.0),   // too far to tell
      TwoRounds::Loop(20, 119, 0.0)};  // too near to the loop itself
  const std::vector<size_t> support =
      FindSupport(TwoRounds::Loop(20, 120, 0.0), others, drive.odometry, drive.path_m, {});
  EXPECT_EQ(support, (std::vector<size_t>{0, 3}));
}

// Near on one pass only: two visits of one place are not one row of street.
TEST(FindSupport, AsksForLoopsThatAreNearOnBothPasses) {
  const TwoRounds drive;
  const auto exact = [](int from, int to) {
    Vector6d motion = Vector6d::Zero();
    motion[2] = (to - from) * 2.0 * 3.14159265358979 / kRound;
    motion[3] = to - from;
    return PoseConstraint{from, to, Rigid3d::Exp(motion), Information(0.002, 0.03)};
  };
  const std::vector<PoseConstraint> others = {exact(15, 170), exact(70, 112), exact(15, 115)};
  EXPECT_EQ(FindSupport(exact(20, 120), others, drive.odometry, drive.path_m, {}),
            (std::vector<size_t>{2}));
  LoopConsistencyOptions anywhere;
  anywhere.max_support_path_m = 1000.0;  // they agree: distance alone keeps them out
  EXPECT_EQ(FindSupport(exact(20, 120), others, drive.odometry, drive.path_m, anywhere).size(), 3U);
}

// Measured as if the current keyframe were 5 m back: wrong, and in the same way everywhere.
PoseConstraint Slid(int history, int current) {
  PoseConstraint loop = TwoRounds::Loop(history, current - 5, 0.0);
  loop.to = current;
  return loop;
}

TEST(FindSupport, LoopsThatAreWrongTogetherSupportEachOtherOnly) {
  const TwoRounds drive;
  const std::vector<PoseConstraint> others = {Slid(10, 110), TwoRounds::Loop(14, 114, 0.0)};
  EXPECT_EQ(FindSupport(Slid(20, 120), others, drive.odometry, drive.path_m, {}),
            (std::vector<size_t>{0}));
}

TEST(OdometryVarianceFactor, IsOneWhereTheOdometryIsHonest) {
  EXPECT_EQ(OdometryVarianceFactor({}), 1.0);
  EXPECT_EQ(OdometryVarianceFactor({0.1, 2.0, 5.0}), 1.0);
  EXPECT_NEAR(OdometryVarianceFactor({5.5, 1.0, 5.0, 9.0, 6.0}), 5.5 / 5.348, 1e-12);
}

TEST(OdometryVarianceFactor, AFewFalseLoopsChangeLittle) {
  EXPECT_NEAR(OdometryVarianceFactor({53.0, 1e6, 54.0, 53.48, 1e7, 50.0, 40.0}), 10.0, 0.2);
}

TEST(WithOdometryVariance, LeavesTheLoopsAlone) {
  PoseGraph graph;
  graph.odometry = {{0, 1, Rigid3d(), Information(1e-3, 0.1)}};
  graph.loops = {{0, 1, Rigid3d(), Information(1e-3, 0.1)}};
  const PoseGraph weaker = WithOdometryVariance(graph, 4.0);
  EXPECT_TRUE(weaker.odometry[0].information.isApprox(Information(2e-3, 0.2)));
  EXPECT_TRUE(weaker.loops[0].information.isApprox(graph.loops[0].information));
}

TEST(GraphChi2, GrowsWithTheErrorAndShrinksWithWhatIsUnknown) {
  const PoseConstraint loop = TwoRounds::Loop(10, 110, 1.0);
  const Rigid3d graph = TwoRounds::Loop(10, 110, 0.0).T_from_to;
  const Matrix6d covariance = Information(1e-3, 0.05).inverse();
  LoopConsistencyOptions options;
  options.drift_share = options.drift_floor_m = options.drift_rad_per_m = 0.0;
  options.link_floor_rad = 0.0;
  const double alone = GraphChi2(loop, graph, covariance, 100.0, options);
  EXPECT_NEAR(alone, 1.0 / (0.05 * 0.05 + 0.03 * 0.03), 1.0);
  options.drift_share = 0.01;
  EXPECT_NEAR(GraphChi2(loop, graph, covariance, 100.0, options), 1.0 / 1.0034, 0.01);
  options.drift_share = 0.0;
  EXPECT_LT(GraphChi2(loop, graph, 4.0 * covariance, 100.0, options), alone);
}

TEST(GraphChi2, MendsMetresOnlyWhereThePathIsLong) {
  const PoseConstraint loop = TwoRounds::Loop(10, 110, 5.0);
  const Rigid3d graph = TwoRounds::Loop(10, 110, 0.0).T_from_to;
  const Matrix6d covariance = Information(1e-3, 0.05).inverse();
  const LoopConsistencyOptions options;
  EXPECT_LT(GraphChi2(loop, graph, covariance, 100.0, options), options.max_chi2);
  EXPECT_GT(GraphChi2(loop, graph, covariance, 50.0, options), options.max_chi2);
}

}  // namespace
}  // namespace tvl
