#include "tvl/loop/loop_verification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tvl/base/check.h"
#include "tvl/loop/test_passes.h"

namespace tvl {
namespace {

using synthetic::IdenticalHouses;
using synthetic::OnStreet;
using synthetic::Passes;
using synthetic::RandomHouses;
using synthetic::TwoPasses;

constexpr int kHistory = 20, kCurrent = 56;

LoopProposal Proposal(LoopGuess guess, const Rigid3d& T_history_current) {
  LoopProposal proposal;
  proposal.history = kHistory;
  proposal.current = kCurrent;
  proposal.guess = guess;
  proposal.T_history_current = T_history_current;
  return proposal;
}

LoopVerdict VerifyFrom(const Passes& passes, const LoopProposal& proposal,
                       const Rigid3d& T_graph = Rigid3d(), int threads = 1) {
  LoopVerifier verifier{LoopVerificationOptions()};
  return verifier.Verify(proposal, {passes.T_odom_lidar, passes.Source(), T_graph, 10.0},
                         Executor(threads));
}

void ExpectTrue(const LoopVerdict& verdict, const Rigid3d& T_true) {
  EXPECT_EQ(verdict.status, LoopStatus::kAccepted) << verdict.reason;
  const Rigid3d error = T_true.Inverse() * verdict.T_history_current;
  EXPECT_LT(error.t().norm(), 0.05);
  EXPECT_LT(error.RotationAngle(), DegToRad(0.1));
  EXPECT_TRUE(verdict.reason.empty());
}

TEST(LoopVerification, FindsATrueLoopFromTheGraphsEstimate) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), false);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  const Rigid3d T_graph = T_true * OnStreet(-6.0, 5.0, DegToRad(8.0));
  ExpectTrue(VerifyFrom(passes, Proposal(LoopGuess::kNone, Rigid3d()), T_graph), T_true);
}

TEST(LoopVerification, FindsATrueLoopFromAYaw) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), true);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  const Rigid3d T_guess = OnStreet(0.0, 0.0, kPi + DegToRad(6.0));
  ExpectTrue(VerifyFrom(passes, Proposal(LoopGuess::kYaw, T_guess)), T_true);
}

TEST(LoopVerification, FindsATrueLoopFromAPose) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), false);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  const Rigid3d T_guess = T_true * OnStreet(0.6, -0.4, DegToRad(2.0));
  ExpectTrue(VerifyFrom(passes, Proposal(LoopGuess::kPose, T_guess)), T_true);
}

TEST(LoopVerification, RefusesAnotherPlace) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(2), false);
  const LoopVerdict verdict =
      VerifyFrom(passes, Proposal(LoopGuess::kYaw, OnStreet(0.0, 0.0, 0.0)));
  EXPECT_THAT(verdict.status, testing::AnyOf(LoopStatus::kHighRms, LoopStatus::kLowOverlap));
  EXPECT_THAT(verdict.reason, testing::HasSubstr("overlap"));
}

TEST(LoopVerification, WhatFitsMustOutweighWhatContradicts) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), false);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  LoopVerificationOptions options;
  options.min_fit = 1.0;  // not even the true place fits that well
  const LoopVerdict verdict = LoopVerifier(options).Verify(
      Proposal(LoopGuess::kPose, T_true), {passes.T_odom_lidar, passes.Source(), Rigid3d(), 10.0},
      Executor(1));
  EXPECT_EQ(verdict.status, LoopStatus::kContradicted) << verdict.reason;
}

TEST(LoopVerification, RefusesATunnelWhoseAxisIsNotHeld) {
  const Passes passes = TwoPasses(synthetic::Tunnel(), synthetic::Tunnel(), false);
  const LoopVerdict verdict =
      VerifyFrom(passes, Proposal(LoopGuess::kYaw, OnStreet(0.0, 0.0, 0.0)));
  EXPECT_THAT(verdict.status, testing::AnyOf(LoopStatus::kWeak, LoopStatus::kAmbiguous));
  EXPECT_LT(verdict.translation_ratio, 0.008);
}

TEST(LoopVerification, RefusesRowsOfIdenticalHouses) {
  const Passes passes = TwoPasses(IdenticalHouses(), IdenticalHouses(), false);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  // Even from the right place: nothing there tells it from the one a house further.
  const LoopVerdict verdict = VerifyFrom(passes, Proposal(LoopGuess::kPose, T_true));
  EXPECT_EQ(verdict.status, LoopStatus::kAmbiguous) << verdict.reason;
  EXPECT_GT(verdict.ambiguity, 0.75);
}

TEST(LoopVerification, RefusesAPlaceWithoutFeatures) {
  const synthetic::World plain{{synthetic::Plane({0, 0, 1}, -1.7)}, {}};
  const LoopVerdict verdict =
      VerifyFrom(TwoPasses(plain, plain, false), Proposal(LoopGuess::kPose, Rigid3d()));
  EXPECT_EQ(verdict.status, LoopStatus::kNoStart);
  EXPECT_FALSE(verdict.reason.empty());
}

TEST(LoopVerification, NeitherThreadsNorWhatCameBeforeChangeABit) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), false);
  const Rigid3d T_true = passes.Truth_T_history_current(kHistory, kCurrent);
  const LoopProposal proposal = Proposal(LoopGuess::kPose, T_true);
  const LoopVerdict alone = VerifyFrom(passes, proposal);
  LoopVerifier verifier{LoopVerificationOptions()};
  const VerificationInput input{passes.T_odom_lidar, passes.Source(), Rigid3d(), 10.0};
  for (const int history : {5, 12, 33}) {
    LoopProposal other = proposal;
    other.history = history;
    other.current = kCurrent - history % 3;
    verifier.Verify(other, input, Executor(3));
  }
  const LoopVerdict after = verifier.Verify(proposal, input, Executor(3));
  EXPECT_EQ(alone.T_history_current.t(), after.T_history_current.t());
  EXPECT_EQ(alone.covariance, after.covariance);
  EXPECT_EQ(alone.overlap, after.overlap);
  EXPECT_EQ(alone.ambiguity, after.ambiguity);
}

TEST(LoopVerification, TheCovarianceCoversTheError) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), true);
  double sum = 0.0;
  int count = 0;
  for (int history = 10; history < 36; history += 5) {
    LoopProposal proposal = Proposal(LoopGuess::kPose, Rigid3d());
    proposal.history = history;
    const Rigid3d T_true = passes.Truth_T_history_current(history, kCurrent);
    proposal.T_history_current = T_true;
    const LoopVerdict verdict = VerifyFrom(passes, proposal);
    const Vector6d e = (T_true.Inverse() * verdict.T_history_current).Log();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(verdict.covariance).eigenvalues()[0], 0.0);
    sum += e.dot(verdict.covariance.inverse() * e) / 6.0;
    ++count;
  }
  EXPECT_LT(sum / count, 3.0);
  EXPECT_GT(sum / count, 0.001) << "far wider than the errors";
}

TEST(LoopVerification, BrokenContractsAreErrors) {
  const Passes passes = TwoPasses(RandomHouses(1), RandomHouses(1), false);
  LoopProposal proposal = Proposal(LoopGuess::kPose, Rigid3d());
  proposal.history = kCurrent;
  EXPECT_THROW(VerifyFrom(passes, proposal), Error);
  LoopVerificationOptions options;
  options.min_overlap = 1.5;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("min_overlap"));
  }
}

}  // namespace
}  // namespace tvl
