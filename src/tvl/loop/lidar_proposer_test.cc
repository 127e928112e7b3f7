#include "tvl/loop/lidar_proposer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/loop/lidar_descriptor_match.h"
#include "tvl/loop/lidar_descriptor_test_world.h"

namespace tvl {
namespace {

using synthetic::OnGround;
using synthetic::Scan;
using synthetic::Street;
using synthetic::Town;
using ::testing::HasSubstr;

// Along the street in one lane, from x = 50 m in steps of 4 m, and back in the other; the estimate
// drifts sideways by drift_m over the whole.
struct ThereAndBack {
  KeyframeTrack track;
  std::vector<Rigid3d> T_town_lidar;
  LidarProposer proposer;

  ThereAndBack(double drift_m, const LidarProposerOptions& options)
      : proposer(LidarDescriptorOptions{}, options) {
    const Town town = Street(250.0, 7);
    const int steps = 36;
    for (int k = 0; k < 2 * steps; ++k) {
      const bool is_back = k >= steps;
      const double along = 50.0 + 4.0 * (is_back ? 2 * steps - 1 - k : k);
      T_town_lidar.push_back(OnGround(along, is_back ? 2.0 : -2.0, is_back ? kPi : 0.0));
      track.stamp.push_back(Timestamp::FromSeconds(k));
      track.path_m.push_back(4.0 * k);
      track.T_world_lidar.push_back(Rigid3d::Translation(0.0, drift_m * k / (2.0 * steps), 0.0) *
                                    T_town_lidar.back());
      proposer.Add(DescribePlace(Scan(town, T_town_lidar.back(), static_cast<uint64_t>(k)), {}));
    }
  }
  std::vector<LoopProposal> Propose(int current) const {
    return proposer.Propose(track, current, LinkedPath(track.path_m, {}, current),
                            DriftOptions{}.lidar(), {});
  }
};

TEST(LidarProposer, FindsTheWayBackInTheOtherLane) {
  const ThereAndBack drive(15.0, {});
  int revisits = 0;
  for (int k = 0; k < drive.track.size(); ++k) {
    const std::vector<LoopProposal> proposals = drive.Propose(k);
    const int eligible = EligibleHistory(drive.track, k, {});
    const int same_place = drive.track.size() - 1 - k;
    if (same_place >= eligible) {
      // Nothing old enough is near: what is proposed must at least be within the shift tried.
      for (const LoopProposal& p : proposals) EXPECT_LT(std::abs(p.history - same_place), 4);
      continue;
    }
    ++revisits;
    ASSERT_FALSE(proposals.empty()) << "keyframe " << k;
    const LoopProposal& p = proposals.front();
    EXPECT_EQ(p.current, k);
    EXPECT_EQ(p.proposer, LoopProposer::kLidar);
    EXPECT_EQ(p.guess, LoopGuess::kPose);
    EXPECT_GT(p.score, 0.5);
    EXPECT_LE(std::abs(p.history - same_place), 1);
    const Rigid3d truth = drive.T_town_lidar[static_cast<size_t>(p.history)].Inverse() *
                          drive.T_town_lidar[static_cast<size_t>(k)];
    const Rigid3d error = truth.Inverse() * p.T_history_current;
    EXPECT_LT(error.t().norm(), 0.5);
    EXPECT_LT(error.RotationAngle(), DegToRad(1.5));
  }
  EXPECT_GT(revisits, 15);
}

TEST(LidarProposer, MatchesBruteForceWithALongShortlist) {
  LidarProposerOptions options;
  options.shortlist = 1000;
  options.shortlist_gap = 1;
  options.max_proposals = 1;
  const ThereAndBack drive(0.0, options);
  for (const int k : {60, 66, 71}) {
    const PlaceMatcher matcher(drive.proposer.descriptor(k), options.max_offset_m, {});
    int best = -1;
    double best_similarity = options.min_similarity;
    for (int h = 0; h < EligibleHistory(drive.track, k, {}); ++h) {
      const double away_m = (drive.track.T_world_lidar[static_cast<size_t>(h)].t() -
                             drive.track.T_world_lidar[static_cast<size_t>(k)].t())
                                .norm();
      const double s = matcher.Match(drive.proposer.descriptor(h)).similarity;
      if (away_m > 40.0 || s <= best_similarity) continue;
      best = h;
      best_similarity = s;
    }
    const std::vector<LoopProposal> proposals = drive.Propose(k);
    ASSERT_EQ(proposals.size(), 1u);
    EXPECT_EQ(proposals[0].history, best);
    EXPECT_DOUBLE_EQ(proposals[0].score, best_similarity);
  }
}

TEST(LidarProposer, TheEstimatesMustAllowIt) {
  EXPECT_TRUE(ThereAndBack(80.0, {}).Propose(70).empty());  // 78 m off after 280 m
}

TEST(LidarProposer, AtMostOneProposalAPass) {
  LidarProposerOptions options;
  options.min_similarity = 0.0;
  options.max_proposals = 20;
  const ThereAndBack drive(0.0, options);
  const std::vector<LoopProposal> proposals = drive.Propose(70);
  EXPECT_GT(proposals.size(), 1u);
  for (const LoopProposal& a : proposals) {
    for (const LoopProposal& b : proposals) {
      if (a.history == b.history) continue;
      EXPECT_GT(4 * std::abs(a.history - b.history), 20);
    }
  }
  for (size_t i = 1; i < proposals.size(); ++i) {
    EXPECT_GE(proposals[i - 1].score, proposals[i].score);
  }
}

TEST(LidarProposer, KeyframesWithoutAScan) {
  ThereAndBack drive(0.0, {});
  drive.proposer.Add({});
  drive.track.stamp.push_back(Timestamp::FromSeconds(100.0));
  drive.track.path_m.push_back(300.0);
  drive.track.T_world_lidar.push_back(drive.track.T_world_lidar[0]);
  EXPECT_TRUE(drive.Propose(72).empty());
  EXPECT_EQ(drive.proposer.size(), 73);
  drive.track.stamp.push_back(Timestamp::FromSeconds(101.0));
  drive.track.path_m.push_back(304.0);
  drive.track.T_world_lidar.push_back(drive.track.T_world_lidar[0]);
  EXPECT_THROW(drive.Propose(73), Error);  // not added
}

TEST(LidarProposerOptions, NamesTheField) {
  const auto message = [](const LidarProposerOptions& options) -> std::string {
    try {
      options.Check();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  LidarProposerOptions good;
  EXPECT_EQ(message(good), "");
  LidarProposerOptions bad = good;
  bad.shortlist = 0;
  EXPECT_THAT(message(bad), HasSubstr("shortlist"));
  bad = good;
  bad.shortlist_gap = 0;
  EXPECT_THAT(message(bad), HasSubstr("shortlist_gap"));
  bad = good;
  bad.max_offset_m = 0.0;
  EXPECT_THAT(message(bad), HasSubstr("max_offset_m"));
  bad = good;
  bad.min_similarity = 1.1;
  EXPECT_THAT(message(bad), HasSubstr("min_similarity"));
  bad = good;
  bad.max_ambiguity = -0.1;
  EXPECT_THAT(message(bad), HasSubstr("max_ambiguity"));
  bad = good;
  bad.max_proposals = 0;
  EXPECT_THAT(message(bad), HasSubstr("max_proposals"));
}

}  // namespace
}  // namespace tvl
