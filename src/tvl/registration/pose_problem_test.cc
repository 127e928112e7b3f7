#include "tvl/registration/pose_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

const Executor kExecutor(1);

// A tube along x with a road in it, some of its points on things that moved, and a little that
// holds the axis: `posts` planes across it.
LaserMatches Tube(const Rigid3d& T_true, int posts, uint64_t seed) {
  Rng rng(seed);
  LaserMatches matches;
  for (int i = 0; i < 1500; ++i) {
    const double phi = rng.Uniform(-3.14, 3.14);
    const bool road = phi < -1.0 && phi > -2.1;
    Eigen::Vector3d n =
        road ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, std::cos(phi), std::sin(phi));
    Eigen::Vector3d p =
        road ? Eigen::Vector3d(0, 4.0 * std::cos(phi), -3.4) : Eigen::Vector3d(4.0 * n);
    p.x() = rng.Uniform(-20, 20);
    if (i < posts) n = Eigen::Vector3d(1, 0, 0);
    PlaneMatch match;
    match.factor = {T_true.Inverse() * (p + 0.02 * rng.Normal() * n), n, p};
    if (i % 10 == 9) match.factor.q_ref += rng.Uniform(-0.5, 0.5) * n;
    match.information = 1.0 / (0.05 * 0.05);
    matches.planes.push_back(match);
  }
  return matches;
}

Matrix6d Covariance(double sigma_rad, double sigma_m) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(sigma_rad * sigma_rad),
      Eigen::Vector3d::Constant(sigma_m * sigma_m);
  return d.asDiagonal();
}

PoseProblemSetup SetupWith(const PriorTerm& prior) {
  PoseProblemSetup setup;
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  setup.extrinsics.T_cam_lidar = Rigid3d(R, Eigen::Vector3d::Zero());
  setup.bins = SweepBins::Compensated();
  setup.prior = prior;
  return setup;
}

Vector6d Twist(double wx, double wy, double wz, double x, double y, double z) {
  Vector6d xi;
  xi << wx, wy, wz, x, y, z;
  return xi;
}

const Rigid3d kTrue = Rigid3d::Exp(Twist(0.004, -0.003, 0.006, 1.2, 0.05, -0.02));

// As many planes across the tube as put the axis between `weak` and `held`, or below, or above.
class PoseProblemInATube : public ::testing::TestWithParam<int> {
 public:
  PoseProblem Problem(const Rigid3d& T_prior, const Rigid3d& T_matched) const {
    PoseProblem problem(SetupWith(PriorTerm::Of(T_prior, Covariance(0.01, 0.05))), kExecutor);
    problem.SetMatches(Tube(kTrue, GetParam(), 3), {}, T_matched);
    return problem;
  }
};

// The equations the solver steps by belong to the cost it compares, at any pose and shift, with
// the robust kernels at work.
TEST_P(PoseProblemInATube, GradientIsThatOfTheCost) {
  const PoseProblem problem = Problem(Rigid3d::Translation(1.1, 0, 0), kTrue);
  const ShiftedPose pose{kTrue * Rigid3d::Exp(Twist(0.003, 0.002, -0.004, 0.1, -0.08, 0.06)),
                         0.05 * problem.weakness().shift.is_free};
  const ShiftedEquations at_pose = problem.Equations(pose);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6d d = kStep * Vector6d::Unit(i);
    const auto cost = [&](const Vector6d& dx, const Vector6d& da) {
      return problem.Equations({pose.T * Rigid3d::Exp(dx), pose.shift + da}).pose.cost;
    };
    const Vector6d zero = Vector6d::Zero();
    const double b_pose = (cost(d, zero) - cost(-d, zero)) / (2.0 * kStep);
    EXPECT_NEAR(b_pose, at_pose.pose.b[i], 1e-4 * at_pose.pose.b.norm());
    if (problem.weakness().shift.is_free[i] == 0.0) continue;
    const double b_shift = (cost(zero, d) - cost(zero, -d)) / (2.0 * kStep);
    EXPECT_NEAR(b_shift, at_pose.b_shift[i], 1e-4 * at_pose.pose.b.norm());
  }
}

// Far from the answer, with outliers: every solution is better than its start and a bottom of the
// one cost, that is, neither the approximated model nor the damping makes the solver stall.
TEST_P(PoseProblemInATube, SolverReachesTheBottomOfTheCost) {
  for (const double offset_m : {-1.0, -0.3, 0.3, 1.0}) {
    const Rigid3d T_start = Rigid3d::Translation(offset_m, 0.05, 0.0) * kTrue;
    const PoseProblem problem = Problem(T_start, T_start);
    double cost = problem.Equations({T_start, Vector6d::Zero()}).pose.cost;
    PoseSolverOptions options;
    options.max_iterations = 1;
    for (int n = 1; n <= 8; ++n) {
      options.max_iterations = n;
      const PoseSolution solution = SolveShiftedPose(
          T_start, [&](const ShiftedPose& at) { return problem.Equations(at); }, options);
      EXPECT_LE(solution.at_T.cost, cost) << "iteration " << n;
      cost = solution.at_T.cost;
    }
    options.max_iterations = 100;
    const PoseSolution bottom = SolveShiftedPose(
        T_start, [&](const ShiftedPose& at) { return problem.Equations(at); }, options);
    const NormalEquations n = bottom.at_T;
    EXPECT_TRUE(bottom.converged);
    EXPECT_LT(n.H.ldlt().solve(n.b).norm(), 1e-4);
    EXPECT_LT((problem.Solve(T_start).T.Inverse() * bottom.T).Log().norm(), 0.05)
        << "three iterations come near";
  }
}

TEST_P(PoseProblemInATube, TheAxisGoesToWhoKnowsIt) {
  const Rigid3d T_prior = Rigid3d::Translation(-0.10, 0.0, 0.0) * kTrue;
  const PoseProblem problem = Problem(T_prior, T_prior);
  const Eigen::Vector3d error = kTrue.t() - problem.Solve(T_prior).T.t();
  EXPECT_NEAR(error.y(), 0.0, 0.01);
  EXPECT_NEAR(error.z(), 0.0, 0.01);
  const auto& weak = problem.weakness().directions;
  if (weak.empty()) {
    EXPECT_LT(error.x(), 0.05);
    return;
  }
  ASSERT_EQ(weak.size(), 1u);
  if (weak[0].say == 0.0) {
    EXPECT_NEAR(error.x(), 0.10, 0.005) << "the prediction stays";
  } else {
    EXPECT_GT(error.x(), 0.0);
    EXPECT_LT(error.x(), 0.10);
  }
}

INSTANTIATE_TEST_SUITE_P(Posts, PoseProblemInATube, ::testing::Values(0, 9, 60));

TEST(PoseProblem, TheThreeTubesAreWeakFadingAndHeld) {
  std::vector<double> says;
  for (const int posts : {0, 9, 60}) {
    PoseProblem problem(SetupWith(PriorTerm::None()), kExecutor);
    problem.SetMatches(Tube(kTrue, posts, 3), {}, kTrue);
    double say = 1.0;
    for (const auto& d : problem.weakness().directions) say = std::min(say, d.say);
    says.push_back(say);
  }
  EXPECT_EQ(says[0], 0.0);
  EXPECT_GT(says[1], 0.0);
  EXPECT_LT(says[1], 1.0);
  EXPECT_EQ(says[2], 1.0);
}

TEST(PoseProblem, WithoutMatchesThePriorIsTheAnswer) {
  Matrix6d covariance = Covariance(0.01, 0.05);
  covariance(2, 4) = covariance(4, 2) = 0.9 * 0.01 * 0.05;  // yaw moves it sideways
  PoseProblemSetup setup = SetupWith(PriorTerm::Of(kTrue, covariance, 0.5));
  setup.covariance.inflation = 1.0;
  setup.step_m = 0.0;
  PoseProblem problem(setup, kExecutor);
  problem.SetMatches({}, {}, Rigid3d());
  PoseSolution solution = problem.Solve(Rigid3d());
  EXPECT_THAT(solution.T, Rigid3dNear(kTrue, 1e-6, 1e-6));
  const Matrix6d found = problem.Covariance(solution);
  EXPECT_NEAR(found(2, 4), covariance(2, 4), 0.02 * covariance(2, 4));
  EXPECT_NEAR(found(4, 4), covariance(4, 4), 0.02 * covariance(4, 4));
}

// A prior that ties yaw to the sideways motion passes on what the laser knows of one of them.
TEST(PoseProblem, CorrelationsOfThePriorCount) {
  LaserMatches wall;  // one plane across y, far too small to hold a rotation
  PlaneMatch match;
  match.factor = {Eigen::Vector3d(0, 5, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 5.04, 0)};
  match.information = 1e8;
  wall.planes.assign(20, match);
  Matrix6d covariance = Covariance(0.01, 0.05);
  const auto yaw = [&] {
    PoseProblemSetup setup = SetupWith(PriorTerm::Of(Rigid3d(), covariance));
    setup.weakness.weak_rotation = setup.weakness.weak_translation = 0.0;
    setup.weakness.held_rotation = setup.weakness.held_translation = 1e-12;
    setup.weakness.normal_sigma_rad = 0.0;
    setup.kernel_sigmas = 1e6;
    PoseProblem problem(setup, kExecutor);
    problem.SetMatches(wall, {}, Rigid3d());
    return problem.Solve(Rigid3d()).T.Log()[2];
  };
  EXPECT_NEAR(yaw(), 0.0, 1e-6);
  covariance(2, 4) = covariance(4, 2) = 0.9 * 0.01 * 0.05;
  EXPECT_NEAR(yaw(), 0.04 * 0.9 * 0.01 / 0.05, 1e-4);
}

// Landmarks ahead seen from `T`.
VisualMatches See(const Rigid3d& T, const Rigid3d& T_cam_lidar, int count, uint64_t seed) {
  Rng rng(seed);
  VisualMatches matches;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(rng.Uniform(8, 20), rng.Uniform(-4, 4), rng.Uniform(-2, 2));
    const Eigen::Vector3d p_cam = T_cam_lidar * (T.Inverse() * p);
    const Eigen::Vector2d ray = p_cam.head<2>() / p_cam.z();
    matches.forward.push_back({{p, ray}, 1e6 * Eigen::Matrix2d::Identity(), 0});
  }
  return matches;
}

TEST(PoseProblem, MatchesThatContradictAreDroppedAndTheRestHoldsTheAxis) {
  const Rigid3d T_prior = Rigid3d::Translation(-0.1, 0.0, 0.0) * kTrue;
  PoseProblemSetup setup = SetupWith(PriorTerm::Of(T_prior, Covariance(0.01, 0.05)));
  VisualMatches visual = See(kTrue, setup.extrinsics.T_cam_lidar, 60, 4);
  const Rigid3d T_lorry = Rigid3d::Translation(0.0, 3.0, 0.0) * kTrue;
  for (const auto& moving : See(T_lorry, setup.extrinsics.T_cam_lidar, 40, 5).forward) {
    visual.forward.push_back(moving);
  }
  PoseProblem problem(setup, kExecutor);
  problem.SetMatches(Tube(kTrue, 0, 3), visual, T_prior);
  EXPECT_EQ(problem.visual().size(), 60u);
  const PoseSolution solution = problem.Solve(T_prior);
  EXPECT_THAT(solution.T, Rigid3dNear(kTrue, 0.002, 0.02));
  const EstimateEvidence evidence = problem.Evidence(solution.T);
  EXPECT_EQ(evidence.planes, 1500);
  EXPECT_EQ(evidence.edges, 0);
  EXPECT_EQ(evidence.visual, 60);
  EXPECT_LT(evidence.visual_rms, 0.005);
  EXPECT_GT(evidence.plane_rms_m, 0.015);
}

TEST(ExtrinsicError, ShowsAMotionAsAnotherOne) {
  const Rigid3d T_cam_lidar = SetupWith({}).extrinsics.T_cam_lidar;
  const Eigen::Vector3d w(0.002, -0.003, 0.001);
  const Rigid3d T_true = Rigid3d(ExpSo3(w), Eigen::Vector3d::Zero()) * T_cam_lidar;
  const Rigid3d T_motion = Rigid3d::Exp(Twist(0.01, 0.02, 0.2, 4.0, 0.5, 0.1));
  const ExtrinsicError error{T_cam_lidar, {}};
  const Rigid3d shown = T_motion * Rigid3d::Exp(error.Effect(T_motion) * w);
  EXPECT_THAT(T_cam_lidar * shown * T_cam_lidar.Inverse(),
              Rigid3dNear(T_true * T_motion * T_true.Inverse(), 2e-6, 5e-5));
}

TEST(ExtrinsicError, AddsItsCovarianceToTheMeasurement) {
  Rng rng(2);
  NormalEquations visual;
  for (int i = 0; i < 20; ++i) {
    const Vector6d row =
        Twist(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
    visual.H += row * row.transpose();
    visual.b += 0.1 * rng.Normal() * row;
  }
  const ExtrinsicError error{SetupWith({}).extrinsics.T_cam_lidar, {}};
  const Eigen::Matrix<double, 6, 3> effect = error.Effect(Rigid3d::Translation(3.0, 0.2, 0.0));
  Eigen::Matrix3d covariance = Eigen::Vector3d(0.1, 0.2, 0.0).asDiagonal();  // may be singular
  const NormalEquations rest = WithExtrinsicError(visual, effect, covariance);
  const Matrix6d expected =
      (visual.H.inverse() + effect * covariance * effect.transpose()).inverse();
  EXPECT_LT((rest.H - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((rest.H.ldlt().solve(rest.b) - visual.H.ldlt().solve(visual.b)).norm(), 1e-9)
      << "alone it says what it said";
}

// The camera points 0.5 deg elsewhere, and everybody believes it: only if that may be so the laser
// keeps the direction of motion, and the camera what the laser does not hold.
TEST(PoseProblem, ExtrinsicsThatMayBeWrongDoNotTurnTheMotion) {
  PoseProblemSetup setup = SetupWith(PriorTerm::Of(kTrue, Covariance(0.1, 0.5)));
  const Rigid3d T_real =
      Rigid3d(ExpSo3({0.006, 0.006, 0.0}), Eigen::Vector3d::Zero()) * setup.extrinsics.T_cam_lidar;
  // Placed by a camera that is off, too, and seen again 5 m further on.
  const Rigid3d T_seen = kTrue * Rigid3d::Translation(-5.0, 0.0, 0.0);
  const Rigid3d T_believed = T_seen * setup.extrinsics.T_cam_lidar.Inverse();
  VisualMatches visual = See(kTrue, T_real, 200, 7);
  for (ReprojectionMatch& match : visual.forward) {
    match.factor.p_ref = T_believed * (T_real * (T_seen.Inverse() * match.factor.p_ref));
  }
  const auto error_m = [&](bool may_be_wrong) {
    if (may_be_wrong) {
      setup.extrinsics.rotation_covariance = 0.009 * 0.009 * Eigen::Matrix3d::Identity();
      setup.T_ref_seen = T_seen;
    }
    PoseProblem problem(setup, kExecutor);
    problem.SetMatches(Tube(kTrue, 0, 3), visual, kTrue);
    EXPECT_GT(problem.visual().size(), 20u);
    return Eigen::Vector3d((kTrue.Inverse() * problem.Solve(kTrue).T).t());
  };
  EXPECT_GT(error_m(false).tail<2>().norm(), 0.01);
  EXPECT_LT(error_m(true).tail<2>().norm(), 0.004);
  EXPECT_LT(std::abs(error_m(true).x()), 0.01);
}

}  // namespace
}  // namespace tvl
