#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/registration/covariance.h"
#include "tvl/registration/laser_terms.h"
#include "tvl/registration/visual_terms.h"
#include "tvl/registration/weakness.h"

namespace tvl {
namespace {

// Points on three mutually perpendicular walls, or on a tube along x.
struct World {
  std::vector<Eigen::Vector3d> points, normals;
};

World Room(Rng& rng) {
  World world;
  for (int i = 0; i < 600; ++i) {
    const int axis = i % 3;
    Eigen::Vector3d p(rng.Uniform(-10, 10), rng.Uniform(-10, 10), rng.Uniform(-10, 10));
    p[axis] = 10.0;
    world.points.push_back(p);
    world.normals.push_back(Eigen::Vector3d::Unit(axis));
  }
  return world;
}

World Tube(Rng& rng, double normal_sigma_rad) {
  World world;
  for (int i = 0; i < 2000; ++i) {
    const double phi = rng.Uniform(-3.14, 3.14);
    // A floor at the bottom: a bare tube would not hold the roll.
    const Eigen::Vector3d n = phi < -1.0 && phi > -2.1
                                  ? Eigen::Vector3d(0, 0, 1)
                                  : Eigen::Vector3d(0, std::cos(phi), std::sin(phi));
    const Eigen::Vector3d p =
        n.z() == 1.0 ? Eigen::Vector3d(0, 4.0 * std::cos(phi), -3.4) : Eigen::Vector3d(4.0 * n);
    world.points.push_back(p + Eigen::Vector3d(rng.Uniform(-20, 20), 0, 0));
    const Eigen::Vector3d e(rng.Normal(), rng.Normal(), rng.Normal());
    world.normals.push_back((n + normal_sigma_rad * e).normalized());
  }
  return world;
}

// Matches of a raw scan: the body at share s of the motion sees the world.
LaserMatches Observe(const World& world, const Rigid3d& T_k_k1, const SweepBins& bins, Rng& rng) {
  LaserMatches matches;
  for (size_t i = 0; i < world.points.size(); ++i) {
    PlaneMatch match;
    match.bin = static_cast<int>(rng.Integer(bins.bins));
    match.factor = {Scale(bins.Share(match.bin), T_k_k1).Inverse() * world.points[i],
                    world.normals[i], world.points[i]};
    match.information = 1.0 / (0.05 * 0.05);
    matches.planes.push_back(match);
  }
  return matches;
}

class Registration : public ::testing::TestWithParam<int> {};

TEST_P(Registration, FindsTheMotionOfASweep) {
  Rng rng(3);
  const SweepBins bins{GetParam()};
  Vector6d xi;
  xi << 0.05, -0.03, 0.3, 1.5, 0.3, -0.1;
  const Rigid3d T_true = Rigid3d::Exp(xi);
  const LaserMatches matches = Observe(Room(rng), T_true, bins, rng);
  const Executor executor(2);
  PoseSolverOptions options;
  options.max_iterations = 20;
  const PoseSolution solution = SolvePose(
      Rigid3d(),
      [&](const Rigid3d& T) { return Linearize(matches, T, bins, 100.0, executor).normal; },
      options);
  EXPECT_THAT(solution.T, Rigid3dNear(T_true, 1e-5, 1e-4));
}

INSTANTIATE_TEST_SUITE_P(CompensatedAndRaw, Registration, ::testing::Values(1, 128));

TEST(Sweep, BinsCoverTheSweep) {
  const SweepBins bins = SweepBins::Raw();
  EXPECT_EQ(bins.BinOf(-0.05, 0.1), 0);
  EXPECT_EQ(bins.BinOf(0.0499999, 0.1), 127);
  EXPECT_NEAR(bins.Share(bins.BinOf(0.02, 0.1)), 1.2, 0.5 / 128);
  EXPECT_EQ(SweepBins::Compensated().BinOf(0.03, 0.1), 0);
  EXPECT_EQ(SweepBins::Compensated().Share(0), 1.0);
}

TEST(Weakness, RoomIsHeldEverywhere) {
  Rng rng(4);
  const LaserMatches matches = Observe(Room(rng), Rigid3d(), SweepBins::Compensated(), rng);
  const LaserSum sum = Linearize(matches, Rigid3d(), SweepBins::Compensated(), 3.0, Executor(1));
  const Weakness weakness = AnalyseWeakness(sum, NormalEquations(), WeaknessOptions());
  EXPECT_TRUE(weakness.directions.empty());
  EXPECT_FALSE(weakness.shift.any());
}

TEST(Weakness, TubeIsWeakAlongItsAxisInSpiteOfNoisyNormals) {
  Rng rng(5);
  const LaserMatches matches = Observe(Tube(rng, 0.03), Rigid3d(), SweepBins::Compensated(), rng);
  const LaserSum sum = Linearize(matches, Rigid3d(), SweepBins::Compensated(), 3.0, Executor(1));
  const Weakness weakness = AnalyseWeakness(sum, NormalEquations(), WeaknessOptions());
  ASSERT_EQ(weakness.directions.size(), 1u);
  EXPECT_FALSE(weakness.directions[0].is_rotation);
  EXPECT_GT(std::abs(weakness.directions[0].axis_lidar.x()), 0.99);
  const NormalEquations masked = WithoutShift(WithShift(sum.normal, ShiftedPose(), weakness.shift));
  EXPECT_LT(masked.H(3, 3), 0.05 * sum.normal.H(3, 3));
  EXPECT_NEAR(masked.H(4, 4), sum.normal.H(4, 4), 0.05 * sum.normal.H(4, 4));
}

TEST(Weakness, WhatNoisyNormalsLeakIsSubtracted) {
  Rng rng(5);
  const LaserMatches matches = Observe(Tube(rng, 0.12), Rigid3d(), SweepBins::Compensated(), rng);
  const LaserSum sum = Linearize(matches, Rigid3d(), SweepBins::Compensated(), 3.0, Executor(1));
  WeaknessOptions options;
  options.normal_sigma_rad = 0.0;
  const Weakness trusting = AnalyseWeakness(sum, NormalEquations(), options);
  EXPECT_GT(trusting.translation_ratio, options.held_translation) << "the axis looks held";
  options.normal_sigma_rad = 0.12;
  const Weakness knowing = AnalyseWeakness(sum, NormalEquations(), options);
  EXPECT_LT(knowing.translation_ratio, options.weak_translation);
}

TEST(VisualTerms, FindTheMotionWithAndWithoutDepth) {
  Rng rng(6);
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Rigid3d T_cam_body(R, Eigen::Vector3d(0.1, -0.08, -0.27));
  Vector6d xi;
  xi << 0.01, -0.02, 0.05, 1.2, 0.1, -0.05;
  const Rigid3d T_true = Rigid3d::Exp(xi);
  VisualMatches matches;
  for (int i = 0; i < 90; ++i) {
    const Eigen::Vector3d p_ref(rng.Uniform(6, 30), rng.Uniform(-6, 6), rng.Uniform(-2, 4));
    const Eigen::Vector3d p_body = T_true.Inverse() * p_ref;
    const Eigen::Vector3d c_ref = T_cam_body * p_ref, c = T_cam_body * p_body;
    const Eigen::Matrix2d information = 1e6 * Eigen::Matrix2d::Identity();
    if (i % 3 == 0) matches.forward.push_back({{p_ref, c.head<2>() / c.z()}, information, 0});
    if (i % 3 == 1) matches.inverse.push_back({{p_body, c_ref.head<2>() / c_ref.z()}, information});
    if (i % 3 == 2) matches.epipolar.push_back({{c.normalized(), c_ref.normalized()}, 1e6});
  }
  PoseSolverOptions options;
  options.max_iterations = 30;
  const PoseSolution solution = SolvePose(
      Rigid3d::Translation(0.8, 0, 0),
      [&](const Rigid3d& T) { return Linearize(matches, T, T_cam_body, 3.0).normal; }, options);
  EXPECT_THAT(solution.T, Rigid3dNear(T_true, 1e-6, 1e-5));
  EXPECT_LT(Chi2(matches.forward[0], T_true, T_cam_body), 1e-12);
}

TEST(VisualTerms, UncertainPointsSayLess) {
  const Eigen::Matrix<double, 2, 3> J = ProjectionJacobian({1.0, 0.5, 10.0});
  const Eigen::Matrix2d sharp = RayInformation(1e-3, J, Eigen::Matrix3d::Zero());
  const Eigen::Matrix2d vague = RayInformation(1e-3, J, Eigen::Matrix3d::Identity());
  EXPECT_NEAR(sharp(0, 0), 1e6, 1.0);
  EXPECT_LT(vague(0, 0), 0.1 * sharp(0, 0));
}

TEST(Sweep, JacobiansOfTheBinsAgreeWithDifferences) {
  Vector6d xi;
  xi << 0.1, -0.2, 0.5, 1.0, -0.4, 0.2;
  const Rigid3d T = Rigid3d::Exp(xi);
  const SweepBins bins{4};
  const SweepMotion motion(bins, T);
  for (int bin = 0; bin < 4; ++bin) {
    const Rigid3d T_bin = Scale(bins.Share(bin), T);
    EXPECT_LT((motion.bins[static_cast<size_t>(bin)].t - T_bin.t()).norm(), 1e-12);
    for (int i = 0; i < 6; ++i) {
      const Vector6d d = 1e-6 * Vector6d::Unit(i);
      const Rigid3d moved = Scale(bins.Share(bin), T * Rigid3d::Exp(d));
      const Vector6d expected = (T_bin.Inverse() * moved).Log() * 1e6;
      EXPECT_LT((motion.bins[static_cast<size_t>(bin)].J.col(i) - expected).norm(), 1e-5);
    }
  }
}

TEST(LaserTerms, SumsAreTheSameToTheBitForAnyThreadCount) {
  Rng rng(7);
  const LaserMatches matches = Observe(Room(rng), Rigid3d(), SweepBins::Raw(), rng);
  const Rigid3d T = Rigid3d::Translation(0.1, 0.2, 0.3);
  const auto sum = [&](int threads) {
    return Linearize(matches, T, SweepBins::Raw(), 2.0, Executor(threads)).normal;
  };
  EXPECT_EQ(sum(1).H, sum(2).H);
  EXPECT_EQ(sum(1).b, sum(2).b);
}

TEST(LaserTerms, OutliersDoNotPull) {
  Rng rng(8);
  LaserMatches matches = Observe(Room(rng), Rigid3d(), SweepBins::Compensated(), rng);
  for (size_t i = 0; i < matches.planes.size(); i += 5) {
    matches.planes[i].factor.q_ref += 2.0 * matches.planes[i].factor.n_ref;
  }
  const auto solve = [&](double kernel_sigmas) {
    return SolvePose(
        Rigid3d(),
        [&](const Rigid3d& T) {
          return Linearize(matches, T, SweepBins::Compensated(), kernel_sigmas, Executor(1)).normal;
        },
        PoseSolverOptions());
  };
  EXPECT_LT(solve(2.0).T.t().norm(), 0.01);
  EXPECT_GT(solve(1e6).T.t().norm(), 0.3);
}

TEST(Weakness, SaysHowMuchTheCameraHolds) {
  Rng rng(9);
  const LaserMatches matches = Observe(Tube(rng, 0.0), Rigid3d(), SweepBins::Compensated(), rng);
  const LaserSum sum = Linearize(matches, Rigid3d(), SweepBins::Compensated(), 3.0, Executor(1));
  NormalEquations visual;
  visual.H = 1e-3 * sum.normal.H.norm() * Matrix6d::Identity();
  const WeaknessOptions options;
  const auto blind = AnalyseWeakness(sum, NormalEquations(), options).directions;
  const auto seeing = AnalyseWeakness(sum, visual, options).directions;
  ASSERT_EQ(blind.size(), 1u);
  ASSERT_EQ(seeing.size(), 1u);
  EXPECT_LT(blind[0].camera_strength, 1e-9);
  EXPECT_GT(seeing[0].camera_strength, 1e-4);
  EXPECT_LT(seeing[0].lidar_strength, options.held_translation);
}

TEST(HonestCovariance, InflatesAndNeverFallsBelowTheFloor) {
  const CovarianceOptions options;
  const Matrix6d loose = HonestCovariance(1e4 * Matrix6d::Identity(), 0.0, options);
  EXPECT_NEAR(loose(3, 3), options.inflation * 1e-4, 0.02 * options.inflation * 1e-4);
  const double length_m = 10.0;
  const Matrix6d tight = HonestCovariance(1e14 * Matrix6d::Identity(), length_m, options);
  EXPECT_NEAR(std::sqrt(tight(4, 4)), options.floor_translation * length_m, 1e-4);
  EXPECT_NEAR(std::sqrt(tight(1, 1)), options.floor_rotation_rad_per_m * length_m, 1e-5);
  EXPECT_GE(HonestCovariance(1e14 * Matrix6d::Identity(), 0.0, options)(5, 5),
            std::pow(options.floor_translation_m, 2));
}

TEST(HonestCovariance, DirectionsNothingHoldsAreUnknown) {
  Matrix6d H = 1e8 * Matrix6d::Identity();
  H(3, 3) = 0.0;
  const Matrix6d covariance = HonestCovariance(H, 1.0, CovarianceOptions());
  EXPECT_GT(std::sqrt(covariance(3, 3)), 5.0);
  EXPECT_LT(std::sqrt(covariance(4, 4)), 0.01);
  CovarianceOptions options;
  options.inflation = 0.5;
  EXPECT_THROW(options.Check(), InputError);
}

// One point 10 m ahead, off the axis, seen a little displaced.
VisualMatches OneDisplaced(double shift, const Rigid3d& T_cam_body) {
  const Eigen::Vector3d p(10.0, 2.0, 1.0), p_cam = T_cam_body * p;
  const Eigen::Vector2d ray(p_cam.x() / p_cam.z() + shift, p_cam.y() / p_cam.z());
  VisualMatches matches;
  matches.forward.push_back({{p, ray}, 1e6 * Eigen::Matrix2d::Identity(), 0});
  matches.inverse.push_back({{p, ray}, 1e6 * Eigen::Matrix2d::Identity()});
  return matches;
}

TEST(Gate, DropsWhatNeitherNoiseNorMotionExplain) {
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Rigid3d T_cam_body(R, Eigen::Vector3d::Zero());
  const VisualMatches matches = OneDisplaced(0.005, T_cam_body);  // 5 sigma
  const Matrix6d certain = 1e-12 * Matrix6d::Identity(), vague = 1e-4 * Matrix6d::Identity();
  EXPECT_EQ(Gate(matches, Rigid3d(), T_cam_body, certain, 3.0).size(), 0u);
  EXPECT_EQ(Gate(matches, Rigid3d(), T_cam_body, certain, 6.0).size(), 2u);
  EXPECT_EQ(Gate(matches, Rigid3d(), T_cam_body, vague, 3.0).size(), 2u);
  // Behind the camera nothing can agree.
  EXPECT_EQ(Gate(matches, Rigid3d::Translation(20, 0, 0), T_cam_body, vague, 1e3).forward.size(),
            0u);
}

}  // namespace
}  // namespace tvl
