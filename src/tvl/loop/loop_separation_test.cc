#include "tvl/loop/loop_separation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

KeyframeTrack TrackOf(const std::vector<double>& stamp_s, const std::vector<double>& path_m) {
  KeyframeTrack track;
  for (const double s : stamp_s) track.stamp.push_back(Timestamp::FromSeconds(s));
  track.path_m = path_m;
  track.T_world_lidar.resize(path_m.size());
  return track;
}

TEST(EligibleHistory, MatchesBruteForce) {
  Rng rng(1);
  const LoopSeparationOptions options;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> stamp_s{0.0}, path_m{0.0};
    for (int k = 1; k < 200; ++k) {
      const bool is_stop = rng.Uniform() < 0.05;
      stamp_s.push_back(stamp_s.back() + (is_stop ? 20.0 : rng.Uniform(0.05, 1.0)));
      path_m.push_back(path_m.back() + rng.Uniform(0.0, 1.2));
    }
    const KeyframeTrack track = TrackOf(stamp_s, path_m);
    for (int c = 0; c < track.size(); c += 7) {
      const size_t cur = static_cast<size_t>(c);
      int expected = 0;
      for (size_t h = 0; h < cur; ++h) {
        const bool is_old = SecondsBetween(track.stamp[h], track.stamp[cur]) > 30.0;
        if (is_old && path_m[cur] - path_m[h] > 50.0) ++expected;
      }
      EXPECT_EQ(EligibleHistory(track, c, options), expected);
    }
  }
}

TEST(EligibleHistory, RedLightIsNoLoop) {
  // Two minutes' standing, a few metres; then a fast round of 100 m in 10 s.
  EXPECT_EQ(EligibleHistory(TrackOf({0, 1, 120, 121}, {0, 2, 3, 4}), 3, {}), 0);
  EXPECT_EQ(EligibleHistory(TrackOf({0, 5, 10}, {0, 50, 100}), 2, {}), 0);
  EXPECT_EQ(EligibleHistory(TrackOf({0, 20, 40}, {0, 50, 100}), 2, {}), 1);
}

TEST(EligibleHistory, BrokenContracts) {
  KeyframeTrack track = TrackOf({0, 1}, {0, 1});
  EXPECT_THROW(EligibleHistory(track, 2, {}), Error);
  EXPECT_THROW(EligibleHistory(track, -1, {}), Error);
  track.path_m.pop_back();
  EXPECT_THROW(EligibleHistory(track, 1, {}), Error);
}

TEST(SeparatePasses, CutsWhereThePathLeaves) {
  LoopSeparationOptions options;
  options.pass_gap_m = 20.0;
  const std::vector<double> path_m{0, 10, 30, 31, 52, 60};
  EXPECT_THAT(SeparatePasses({0, 1, 2, 3, 4, 5}, path_m, options),
              ElementsAre(ElementsAre(0, 1, 2, 3), ElementsAre(4, 5)));
  EXPECT_THAT(SeparatePasses({0, 3}, path_m, options), ElementsAre(ElementsAre(0), ElementsAre(3)));
  EXPECT_THAT(SeparatePasses({}, path_m, options), IsEmpty());
}

TEST(LoopSeparationOptions, NamesTheField) {
  const auto message = [](const LoopSeparationOptions& options) -> std::string {
    try {
      options.Check();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({-1.0, 50.0, 20.0}), HasSubstr("min_time_s"));
  EXPECT_THAT(message({30.0, -1.0, 20.0}), HasSubstr("min_path_m"));
  EXPECT_THAT(message({30.0, 50.0, 0.0}), HasSubstr("pass_gap_m"));
}

}  // namespace
}  // namespace tvl
