#include "tvl/loop/vicinity_proposer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// Rounds of a circuit of `length_m`, one keyframe a metre and half a second, drifting outwards.
KeyframeTrack Rounds(int rounds, double length_m, double drift_m) {
  KeyframeTrack track;
  const double radius_m = length_m / (2.0 * kPi);
  for (int k = 0; k < rounds * static_cast<int>(length_m); ++k) {
    const double angle = 2.0 * kPi * k / length_m, r = radius_m + drift_m * k / length_m;
    track.stamp.push_back(Timestamp::FromSeconds(0.5 * k));
    track.path_m.push_back(k);
    track.T_world_lidar.push_back({ExpSo3({0.0, 0.0, angle}),
                                   Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0.0)});
  }
  return track;
}

std::vector<LoopProposal> Propose(const KeyframeTrack& track, int current, int max_passes = 2,
                                  const std::vector<LoopLink>& loops = {}) {
  return ProposeVicinity(track, current, LinkedPath(track.path_m, loops, current),
                         DriftOptions{}.vicinity(), {}, {max_passes});
}

TEST(ProposeVicinity, ClosestOfEachPass) {
  const KeyframeTrack track = Rounds(4, 200.0, 1.0);
  const int current = 3 * 200 + 100;
  const std::vector<LoopProposal> all = Propose(track, current, 9);
  ASSERT_EQ(all.size(), 3u);  // the three rounds before, the last one closest
  EXPECT_EQ(all[0].history, 500);
  EXPECT_EQ(all[1].history, 300);
  EXPECT_EQ(all[2].history, 100);
  EXPECT_NEAR(all[0].score, 1.0, 1e-9);
  EXPECT_NEAR(all[2].score, 3.0, 1e-9);
  EXPECT_EQ(Propose(track, current).size(), 2u);
}

TEST(ProposeVicinity, ProposalSaysWhatTheEstimateSays) {
  const KeyframeTrack track = Rounds(2, 200.0, 3.0);
  const std::vector<LoopProposal> proposals = Propose(track, 320);
  ASSERT_EQ(proposals.size(), 1u);
  const LoopProposal& p = proposals[0];
  EXPECT_EQ(p.current, 320);
  EXPECT_EQ(p.proposer, LoopProposer::kVicinity);
  EXPECT_EQ(p.guess, LoopGuess::kNone);
  const Rigid3d back = track.T_world_lidar[static_cast<size_t>(p.history)] * p.T_history_current;
  EXPECT_NEAR((back.t() - track.T_world_lidar[320].t()).norm(), 0.0, 1e-9);
}

TEST(ProposeVicinity, MatchesBruteForce) {
  Rng rng(5);
  KeyframeTrack track;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  double heading = 0.0;
  for (int k = 0; k < 1500; ++k) {  // about a square of 60 m, round and round
    track.stamp.push_back(Timestamp::FromSeconds(0.4 * k));
    track.path_m.push_back(k);
    heading = kPi / 2.0 * std::floor(k / 60.0) + 0.1 * rng.Normal();
    p += Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.02 * rng.Normal());
    track.T_world_lidar.push_back({ExpSo3({0.0, 0.0, heading}), p});
  }
  const std::vector<LoopLink> loops{{400, 100}, {900, 300}};
  int proposed = 0;
  for (int c = 0; c < track.size(); c += 13) {
    const std::vector<double> linked_m = LinkedPath(track.path_m, loops, c);
    const std::vector<LoopProposal> proposals = Propose(track, c, 1, loops);
    const size_t cur = static_cast<size_t>(c);
    int closest = -1;
    double closest_m = 1e9;
    for (size_t h = 0; h < cur; ++h) {
      const double d = (track.T_world_lidar[h].t() - track.T_world_lidar[cur].t()).norm();
      const bool is_old =
          0.4 * (c - static_cast<double>(h)) > 30.0 && track.path_m[cur] - track.path_m[h] > 50.0;
      if (!is_old || d > std::max(10.0, 0.005 * linked_m[h]) || d >= closest_m) continue;
      closest = static_cast<int>(h);
      closest_m = d;
    }
    ASSERT_EQ(proposals.size(), closest < 0 ? 0u : 1u);
    if (closest < 0) continue;
    ++proposed;
    EXPECT_EQ(proposals[0].history, closest);
    EXPECT_DOUBLE_EQ(proposals[0].score, closest_m);
  }
  EXPECT_GT(proposed, 20);
}

TEST(ProposeVicinity, RadiusGrowsWithTheLinkedPath) {
  // One round of 3 km that comes back 14 m beside its start: within 0.5 % of it, until a loop
  // further on has shown how little it drifted.
  const KeyframeTrack track = Rounds(2, 3000.0, 14.0);
  const std::vector<LoopProposal> before = Propose(track, 3000);
  ASSERT_EQ(before.size(), 1u);
  EXPECT_NEAR(before[0].score, 14.0, 1.0);
  EXPECT_TRUE(Propose(track, 3100, 2, {{3000, 0}}).empty());
}

TEST(VicinityOptions, Checked) {
  EXPECT_NO_THROW(VicinityOptions{}.Check());
  EXPECT_THROW(VicinityOptions{0}.Check(), InputError);
  const KeyframeTrack track = Rounds(2, 200.0, 0.0);
  EXPECT_THROW(ProposeVicinity(track, 300, {}, DriftOptions{}.vicinity(), {}, {}), Error);
}

}  // namespace
}  // namespace tvl
