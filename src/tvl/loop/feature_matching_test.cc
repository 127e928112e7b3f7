#include "tvl/loop/feature_matching.h"

#include <gtest/gtest.h>

#include <set>

#include "tvl/base/check.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

// All features under one node.
DirectIndex OneNode(const ImageFeatures& features) {
  DirectIndex index;
  for (size_t i = 0; i < features.size(); ++i) {
    index.node.push_back(1);
    index.feature.push_back(static_cast<uint16_t>(i));
  }
  return index;
}

ImageFeatures With(const std::vector<BinaryDescriptor>& descriptors) {
  ImageFeatures features;
  features.descriptors = descriptors;
  return features;
}

TEST(FeatureMatching, FindsThePairsOfAPlaceSeenTwice) {
  const Place place = MakePlace(150, 1);
  const ImageFeatures a = See(place, Rigid3d(), 1.0, 1);
  const ImageFeatures b = See(place, Rigid3d::Translation(0, 0, 0.5), 1.0, 2);
  const auto pairs = MatchFeatures(a, OneNode(a), b, OneNode(b), {});
  EXPECT_EQ(pairs.size(), 150U);
  for (const FeaturePair& p : pairs) {
    const auto i = static_cast<size_t>(p.history), j = static_cast<size_t>(p.current);
    const Eigen::Vector3f in_a = a.depth_m[i] * a.ray_cam[i].homogeneous();
    const Eigen::Vector3f in_b = b.depth_m[j] * b.ray_cam[j].homogeneous();
    EXPECT_LT((in_a - in_b - Eigen::Vector3f(0, 0, 0.5f)).norm(), 0.1f);
  }
}

TEST(FeatureMatching, ComparesWithinANodeOnly) {
  const Place place = MakePlace(20, 2);
  const ImageFeatures a = See(place, Rigid3d(), 1.0, 1);
  DirectIndex halves = OneNode(a);
  for (size_t i = 10; i < 20; ++i) halves.node[i] = 4;
  DirectIndex shifted = halves;  // the first ten under 4 and then 7: only these meet the others
  for (size_t i = 0; i < 20; ++i) shifted.node[i] = i < 10 ? 4 : 7;
  for (const FeaturePair& p : MatchFeatures(a, halves, a, halves, {})) {
    EXPECT_EQ(p.history, p.current);
  }
  EXPECT_EQ(MatchFeatures(a, halves, a, halves, {}).size(), 20U);
  EXPECT_TRUE(MatchFeatures(a, halves, a, shifted, {}).empty());
}

TEST(FeatureMatching, RepeatedAndDistantDescriptorsAreLeftOut) {
  Rng rng(3);
  const BinaryDescriptor window = RandomDescriptor(rng), door = RandomDescriptor(rng);
  const BinaryDescriptor lamp = RandomDescriptor(rng);
  const ImageFeatures history = With({window, door, lamp});
  // The window stands there twice; the door has changed by more than the bound.
  const ImageFeatures current = With({window, window, WithNoise(door, 200, rng), lamp});
  const auto pairs = MatchFeatures(history, OneNode(history), current, OneNode(current), {});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].history, 2);
  EXPECT_EQ(pairs[0].current, 3);
}

TEST(FeatureMatching, IsOneToOneAndSymmetric) {
  const ImageFeatures a = See(MakePlace(60, 4), Rigid3d(), 1.0, 1);
  ImageFeatures b = See(MakePlace(60, 4), Rigid3d(), 1.0, 2);
  FeatureMatchingOptions loose;
  loose.max_distance_bits = 256;
  loose.max_ratio = 1.0;
  std::set<int> used;
  std::set<std::pair<int, int>> there, back;
  for (const FeaturePair& p : MatchFeatures(a, OneNode(a), b, OneNode(b), loose)) {
    EXPECT_TRUE(used.insert(p.current).second);
    there.insert({p.history, p.current});
  }
  for (const FeaturePair& p : MatchFeatures(b, OneNode(b), a, OneNode(a), loose)) {
    back.insert({p.current, p.history});
  }
  EXPECT_EQ(there, back);
}

TEST(FeatureMatching, TwoThatWantTheSameOneAreNotBothServed) {
  Rng rng(5);
  const BinaryDescriptor sign = RandomDescriptor(rng);
  const ImageFeatures history = With({WithNoise(sign, 20, rng), sign});
  const ImageFeatures current = With({sign});
  const auto pairs = MatchFeatures(history, OneNode(history), current, OneNode(current), {});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].history, 1);
}

TEST(FeatureMatching, OptionsAreChecked) {
  FeatureMatchingOptions options;
  options.max_ratio = 0.0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.max_distance_bits = 300;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
