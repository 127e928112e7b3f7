#include "tvl/registration/weakness.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr int kSeeds = 200;
const std::vector<double> kSays = {1.0, 0.999, 0.9, 0.7, 0.5, 0.3, 0.1, 0.01, 0.0};

Vector6d RandomVector(Rng& rng) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = rng.Normal();
  return v;
}

// Information of a laser: full, coupled, strengths of a block spread over three decades, but far
// from so weak that the bound on the largest shift would show.
Matrix6d RandomInformation(Rng& rng) {
  Matrix6d A;
  for (int i = 0; i < 6; ++i) A.col(i) = RandomVector(rng);
  Vector6d scale;
  for (int i = 0; i < 6; ++i) scale[i] = (i < 3 ? 1e4 : 1e3) * std::pow(10.0, rng.Uniform(-1.5, 0));
  const Matrix6d J = A * scale.asDiagonal();
  Matrix6d H = J.transpose() * J;
  H += 1e-2 * Matrix6d(H.diagonal().asDiagonal());
  return H;
}

// Equations of 0.5 (x - answer)' H (x - answer) at x = 0.
NormalEquations Quadratic(const Matrix6d& H, const Vector6d& answer) {
  NormalEquations n;
  n.H = H;
  n.b = -H * answer;
  n.cost = 0.5 * answer.dot(H * answer);
  return n;
}

Matrix6d CovarianceOf(const Matrix6d& H) { return H.inverse(); }

Eigen::Matrix3d MarginalInformation(const Matrix6d& H, int first) {
  return Eigen::Matrix3d(CovarianceOf(H).block<3, 3>(first, first)).inverse();
}

struct Laser {
  Matrix6d H, axes = Matrix6d::Zero();
  Vector6d answer, lambda;

  explicit Laser(Rng& rng) : H(RandomInformation(rng)), answer(0.1 * RandomVector(rng)) {
    for (const int first : {0, 3}) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(MarginalInformation(H, first));
      axes.block<3, 3>(first, first) = eigen.eigenvectors();
      lambda.segment<3>(first) = eigen.eigenvalues();
    }
  }
  // With the shift eliminated.
  NormalEquations With(const Vector6d& say) const {
    const LaserShift shift = MakeLaserShift(axes, lambda, say);
    return WithoutShift(WithShift(Quadratic(H, answer), {Rigid3d(), Vector6d::Zero()}, shift));
  }
  NormalEquations With(int column, double say) const {
    Vector6d says = Vector6d::Ones();
    says[column] = say;
    return With(says);
  }
};

Vector6d Answer(NormalEquations laser, const NormalEquations& other) {
  laser += other;
  return -laser.H.ldlt().solve(laser.b);
}

// What else there is knows both blocks alike in all directions.
Matrix6d Isotropic(double rotation, double translation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
  return d.asDiagonal();
}

TEST(LaserShift, MovesFromTheLasersAnswerToTheOthersAsTheSayFalls) {
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const Laser laser(rng);
    const Vector6d others_answer = 0.1 * RandomVector(rng);
    const bool is_isotropic = seed % 2 == 0;
    const Matrix6d H_other = is_isotropic ? Isotropic(1e4, 400.0) : RandomInformation(rng);
    const NormalEquations other = Quadratic(H_other, others_answer);
    for (int column = 0; column < 6; ++column) {
      const Vector6d axis = laser.axes.col(column);
      const double unmasked = axis.dot(Answer(Quadratic(laser.H, laser.answer), other));
      const double at_zero = axis.dot(Answer(laser.With(column, 0.0), other));
      const double tolerance = 1e-6 * (1e-3 + std::abs(unmasked - at_zero));
      double last = 0.0;
      for (const double say : kSays) {
        const double share =
            (axis.dot(Answer(laser.With(column, say), other)) - unmasked) * (at_zero - unmasked);
        EXPECT_GE(share, last - tolerance) << "seed " << seed << " say " << say;
        last = share;
      }
      if (is_isotropic) {
        EXPECT_NEAR(at_zero, axis.dot(others_answer), 1e-4) << "seed " << seed;
      }
    }
  }
}

TEST(LaserShift, NeverLengthensTheStepAwayFromThePrediction) {
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const Laser laser(rng);
    const NormalEquations other = Quadratic(Isotropic(1e4, 400.0), Vector6d::Zero());
    for (int column = 0; column < 6; ++column) {
      const auto length = [&](const NormalEquations& n) {
        return std::abs(laser.axes.col(column).dot(Answer(n, other)));
      };
      const double unmasked = length(Quadratic(laser.H, laser.answer));
      for (const double say : kSays) EXPECT_LE(length(laser.With(column, say)), unmasked + 1e-5);
    }
  }
}

// The covariance grows along the axis and nowhere else, which is why the other block's marginal is
// what it was, and why directions may be eliminated in any order.
TEST(LaserShift, AddsVarianceAlongTheAxisOnly) {
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const Laser laser(rng);
    Vector6d say, variance;
    for (int i = 0; i < 6; ++i) say[i] = rng.Uniform(0.05, 1.0);
    for (int i = 0; i < 6; ++i) variance[i] = (1.0 - say[i]) / (say[i] * laser.lambda[i]);
    const Matrix6d before = CovarianceOf(laser.H), after = CovarianceOf(laser.With(say).H);
    const Matrix6d expected = before + laser.axes * variance.asDiagonal() * laser.axes.transpose();
    const Vector6d sigma = expected.diagonal().cwiseSqrt();
    const Matrix6d relative =
        sigma.cwiseInverse().asDiagonal() * (after - expected) * sigma.cwiseInverse().asDiagonal();
    EXPECT_LT(relative.cwiseAbs().maxCoeff(), 1e-4) << "seed " << seed;
    const Vector6d kept = (laser.axes.transpose() * laser.With(say).H * laser.axes).diagonal();
    EXPECT_TRUE((kept.array() > 0.0).all());
  }
}

TEST(LaserShift, KeepsItsShareOfTheMarginalInformation) {
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const Laser laser(rng);
    for (int column = 0; column < 6; ++column) {
      const int first = column < 3 ? 0 : 3;
      const Eigen::Vector3d axis = laser.axes.block<3, 1>(first, column);
      const double kept = axis.dot(MarginalInformation(laser.With(column, 0.3).H, first) * axis);
      EXPECT_NEAR(kept, 0.3 * laser.lambda[column], 1e-3 * laser.lambda[column]);
    }
  }
}

TEST(LaserShift, ABlockWithoutSayLeavesTheOtherItsMarginal) {
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const Laser laser(rng);
    for (const int first : {0, 3}) {
      const int other = 3 - first;
      Vector6d say = Vector6d::Ones();
      say.segment<3>(first).setZero();
      const NormalEquations n = laser.With(say);
      const Eigen::Matrix3d marginal = MarginalInformation(laser.H, other);
      const Eigen::Matrix3d H_other = n.H.block<3, 3>(other, other);
      const Eigen::Matrix3d H_first = n.H.block<3, 3>(first, first);
      EXPECT_LT((H_other - marginal).norm(), 1e-3 * marginal.norm());
      const Eigen::Matrix3d H_before = laser.H.block<3, 3>(first, first);
      EXPECT_LT(H_first.norm(), 1e-3 * H_before.norm());
      // The marginal's answer is the laser's own.
      const Vector6d x = Answer(n, Quadratic(Isotropic(1.0, 1.0), Vector6d::Zero()));
      const Eigen::Vector3d gradient =
          marginal * (x - laser.answer).segment<3>(other) + x.segment<3>(other);
      EXPECT_LT(gradient.norm(), 1e-3 * marginal.norm() * laser.answer.norm());
    }
  }
}

TEST(LaserShift, FullSayChangesNothing) {
  Rng rng(1);
  const Laser laser(rng);
  const NormalEquations n = laser.With(Vector6d::Ones());
  EXPECT_EQ(n.H, laser.H);
  EXPECT_EQ(n.cost, Quadratic(laser.H, laser.answer).cost);
}

TEST(LaserShift, ADirectionNothingHoldsDoesNoHarm) {
  Matrix6d H = Isotropic(1e6, 1e4);
  H(3, 3) = 0.0;
  Vector6d say = Vector6d::Ones();
  say[3] = 0.0;
  const LaserShift shift = MakeLaserShift(Matrix6d::Identity(), H.diagonal(), say);
  const auto at = [&](const ShiftedPose& pose) {
    const Rigid3d T = ShiftedByLaser(pose, shift);
    return WithShift(Quadratic(H, -T.Log()), pose, shift);
  };
  const PoseSolution solution = SolveShiftedPose(Rigid3d::Translation(2, 0, 1), at, {});
  EXPECT_NEAR(solution.T.t().x(), 2.0, 1e-6) << "nothing moves it";
  EXPECT_NEAR(solution.T.t().z(), 0.0, 1e-4);
  EXPECT_TRUE(solution.at_T.H.allFinite());
}

// Laser alone says 0.10 m, the prediction 0; the unmasked answer is 0.092 m.
TEST(LaserShift, AnswerFallsFromTheLasersToThePredictions) {
  const Vector6d lambda = Isotropic(1e6, 4600.0).diagonal();
  double last_m = 0.1;
  for (const double say : kSays) {
    Vector6d says = Vector6d::Ones();
    says[3] = say;
    const LaserShift shift = MakeLaserShift(Matrix6d::Identity(), lambda, says);
    const auto at = [&](const ShiftedPose& pose) {
      Vector6d laser_says = Vector6d::Zero();
      laser_says[3] = 0.1;
      const Vector6d x = ShiftedByLaser(pose, shift).Log();
      ShiftedEquations n = WithShift(Quadratic(lambda.asDiagonal(), laser_says - x), pose, shift);
      n.pose += Quadratic(Isotropic(1e4, 400.0), -pose.T.Log());
      return n;
    };
    PoseSolverOptions options;
    options.max_iterations = 10;
    const double x_m = SolveShiftedPose(Rigid3d(), at, options).T.t().x();
    if (say == 1.0) {
      EXPECT_NEAR(x_m, 0.092, 1e-4);
    }
    EXPECT_LT(x_m, last_m);
    last_m = x_m;
  }
  EXPECT_NEAR(last_m, 0.0, 1e-5);
}

// Points of the ground around the lidar, with normals that are off by `normal_sigma_rad`.
LaserMatches Plain(double normal_sigma_rad, uint64_t seed) {
  Rng rng(seed);
  LaserMatches matches;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-25, 25), rng.Uniform(-25, 25), -1.7);
    const Eigen::Vector3d n(normal_sigma_rad * rng.Normal(), normal_sigma_rad * rng.Normal(), 1.0);
    matches.planes.push_back({{p, n.normalized(), p}, 1.0 / (0.05 * 0.05)});
  }
  return matches;
}

bool IsYaw(const WeakDirection& weak) {
  return weak.is_rotation && std::abs(weak.axis_lidar.z()) > 0.9;
}

// Noise in the normals is no knowledge of the yaw, nor of the way over the plain.
TEST(AnalyseWeakness, OnThePlainYawAndBothWaysAreWeak) {
  for (const double sigma_rad : {0.0, 0.02, 0.035}) {
    const LaserSum laser =
        Linearize(Plain(sigma_rad, 4), Rigid3d(), SweepBins::Compensated(), 2.0, Executor(1));
    const Weakness weakness = AnalyseWeakness(laser, NormalEquations(), WeaknessOptions());
    int translations = 0, yaws = 0;
    for (const WeakDirection& weak : weakness.directions) {
      translations += !weak.is_rotation && std::abs(weak.axis_lidar.z()) < 0.1;
      yaws += IsYaw(weak);
    }
    EXPECT_EQ(translations, 2) << sigma_rad;
    EXPECT_EQ(yaws, 1) << sigma_rad;
    EXPECT_EQ(weakness.directions.size(), 3U) << sigma_rad;
  }
}

// A wall 10 m away holds the yaw, and the way towards it.
TEST(AnalyseWeakness, OneWallHoldsTheYaw) {
  LaserMatches matches = Plain(0.035, 5);
  Rng rng(6);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-15, 15), 10.0, rng.Uniform(-1.5, 1.0));
    matches.planes.push_back({{p, Eigen::Vector3d(0, 1, 0), p}, 1.0 / (0.05 * 0.05)});
  }
  const LaserSum laser = Linearize(matches, Rigid3d(), SweepBins::Compensated(), 2.0, Executor(1));
  const Weakness weakness = AnalyseWeakness(laser, NormalEquations(), WeaknessOptions());
  ASSERT_EQ(weakness.directions.size(), 1U);
  EXPECT_GT(std::abs(weakness.directions.front().axis_lidar.x()), 0.99);
}

}  // namespace
}  // namespace tvl
