#include "tvl/loop/guided_matching.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

// One place seen from two positions, 1 m apart; the second image in the order of the first.
struct Views {
  ImageFeatures history, current;
  Rigid3d T_history_current = Rigid3d::Translation(0.2, 0.0, 1.0);

  explicit Views(double depth_share) {
    const Place place = MakePlace(200, 1);
    history = SeeInOrder(place, {}, depth_share, 2);
    current = SeeInOrder(place, T_history_current, depth_share, 3);
  }
  static ImageFeatures SeeInOrder(const Place& place, const Rigid3d& T, double share,
                                  uint64_t seed) {
    ImageFeatures all;
    for (const PlacePoint& point : place) {
      const ImageFeatures one = See({point}, T, 1.0, seed++);
      all.px_cam.push_back(one.px_cam[0]);
      all.ray_cam.push_back(one.ray_cam[0]);
      const bool has_depth = static_cast<double>(seed % 10) < 10.0 * share;
      all.depth_m.push_back(has_depth ? one.depth_m[0] : 0.0f);
      all.descriptors.push_back(one.descriptors[0]);
    }
    return all;
  }
};

int CountTrue(const std::vector<FeaturePair>& pairs) {
  int count = 0;
  for (const FeaturePair& pair : pairs) count += pair.history == pair.current ? 1 : 0;
  return count;
}

TEST(GuidedMatching, FindsThePairsThatHaveADepthOnEitherSide) {
  const Views views(0.5);
  const auto pairs = MatchGuided(views.history, views.current, views.T_history_current, {});
  EXPECT_GE(CountTrue(pairs), 100);
  EXPECT_EQ(CountTrue(pairs), static_cast<int>(pairs.size()));
  for (const FeaturePair& pair : pairs) {
    const auto h = static_cast<size_t>(pair.history), c = static_cast<size_t>(pair.current);
    EXPECT_TRUE(views.history.depth_m[h] > 0.0f || views.current.depth_m[c] > 0.0f);
  }
}

TEST(GuidedMatching, DepthOfTheCurrentImageAloneIsEnough) {
  Views views(1.0);
  views.history.depth_m.assign(views.history.size(), 0.0f);
  EXPECT_GE(CountTrue(MatchGuided(views.history, views.current, views.T_history_current, {})), 195);
}

TEST(GuidedMatching, WhatLooksDifferentIsNoPair) {
  Views views(1.0);
  Rng rng(5);
  for (BinaryDescriptor& d : views.current.descriptors) d = RandomDescriptor(rng);
  EXPECT_LE(MatchGuided(views.history, views.current, views.T_history_current, {}).size(), 1U);
}

TEST(GuidedMatching, WhatIsElsewhereIsNoPair) {
  const Views views(1.0);
  const Rigid3d T_wrong = Rigid3d::Translation(3.0, 0.0, 1.0);
  EXPECT_LE(MatchGuided(views.history, views.current, T_wrong, {}).size(), 5U);
}

TEST(GuidedMatching, AFeatureIsInOnePairAtTheMost) {
  Views views(1.0);
  // Everything twice in the current image, the second time with some more bits changed.
  Rng rng(7);
  const size_t n = views.current.size();
  for (size_t i = 0; i < n; ++i) {
    views.current.px_cam.push_back(views.current.px_cam[i]);
    views.current.ray_cam.push_back(views.current.ray_cam[i]);
    views.current.depth_m.push_back(views.current.depth_m[i]);
    views.current.descriptors.push_back(WithNoise(views.current.descriptors[i], 30, rng));
  }
  const auto pairs = MatchGuided(views.history, views.current, views.T_history_current, {});
  EXPECT_GE(CountTrue(pairs), 195);
  EXPECT_EQ(CountTrue(pairs), static_cast<int>(pairs.size()));
}

TEST(GuidedMatching, NothingToMatch) {
  EXPECT_TRUE(MatchGuided({}, {}, {}, {}).empty());
  EXPECT_TRUE(MatchGuided(Views(1.0).history, {}, {}, {}).empty());
}

TEST(GuidedMatching, OptionsAreChecked) {
  GuidedMatchingOptions options;
  options.max_error_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.max_distance_bits = 257;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
