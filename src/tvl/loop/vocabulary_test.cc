#include "tvl/loop/vocabulary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "tvl/base/check.h"
#include "tvl/loop/hamming.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

using Images = std::vector<std::vector<BinaryDescriptor>>;

// `images` of 60 descriptors, each a noisy copy of one of `kinds`.
Images MakeImages(int images, int kinds, uint64_t seed) {
  Rng rng(seed);
  std::vector<BinaryDescriptor> centres;
  for (int i = 0; i < kinds; ++i) centres.push_back(RandomDescriptor(rng));
  Images result(static_cast<size_t>(images));
  for (auto& image : result) {
    for (int i = 0; i < 60; ++i) {
      image.push_back(WithNoise(centres[static_cast<size_t>(rng.Integer(kinds))], 10, rng));
    }
  }
  return result;
}

VocabularyOptions Small(int branching, int levels) {
  VocabularyOptions options;
  options.branching = branching;
  options.levels = levels;
  return options;
}

TEST(Hamming, CountsBitsThatDiffer) {
  EXPECT_EQ(HammingDistance({0, 0, 0, 0}, {~0ULL, ~0ULL, ~0ULL, ~0ULL}), 256);
  EXPECT_EQ(HammingDistance({1, 2, 4, 8}, {1, 2, 4, 8}), 0);
  for (int bit = 0; bit < 64; ++bit) EXPECT_EQ(CountOnes(1ULL << bit), 1);
  EXPECT_EQ(CountOnes(0xF0F0F0F0F0F0F0F1ULL), 33);
}

TEST(Vocabulary, ClustersBecomeWords) {
  // 8 kinds 110 bits apart, noise of 10: two levels of three children hold them apart.
  Images images = MakeImages(20, 8, 1);
  images.push_back({images[0][0]});  // one in which the other words are not
  const Vocabulary vocabulary = Vocabulary::Train(images, Small(8, 1), 1);
  EXPECT_EQ(vocabulary.words(), 8);
  // Every word's descriptor is the majority of its kind: free of noise, so near to its members.
  for (const BinaryDescriptor& d : images[3]) {
    const int32_t word = vocabulary.Find(d, 0).word;
    const int32_t leaf = vocabulary.leaf_of_word()[static_cast<size_t>(word)];
    EXPECT_LE(HammingDistance(d, vocabulary.nodes()[static_cast<size_t>(leaf)].descriptor), 14);
  }
}

TEST(Vocabulary, IsTheSameForTheSameSeedOnly) {
  const Images images = MakeImages(10, 50, 2);
  const auto bits = [&](uint64_t seed) {
    std::vector<BinaryDescriptor> all;
    const Vocabulary vocabulary = Vocabulary::Train(images, Small(4, 3), seed);
    for (const VocabularyNode& n : vocabulary.nodes()) all.push_back(n.descriptor);
    return all;
  };
  EXPECT_EQ(bits(1), bits(1));
  EXPECT_NE(bits(1), bits(2));
}

TEST(Vocabulary, FindGoesAlongTheNearestChild) {
  const Images images = MakeImages(20, 60, 3);
  const Vocabulary vocabulary = Vocabulary::Train(images, Small(4, 3), 1);
  const auto& nodes = vocabulary.nodes();
  for (const BinaryDescriptor& d : images[0]) {
    std::vector<int32_t> way = {0};
    while (nodes[static_cast<size_t>(way.back())].children > 0) {
      const VocabularyNode& node = nodes[static_cast<size_t>(way.back())];
      int32_t nearest = node.first_child;
      for (int32_t c = nearest; c < node.first_child + node.children; ++c) {
        if (HammingDistance(d, nodes[static_cast<size_t>(c)].descriptor) <
            HammingDistance(d, nodes[static_cast<size_t>(nearest)].descriptor)) {
          nearest = c;
        }
      }
      EXPECT_EQ(nodes[static_cast<size_t>(nearest)].parent, way.back());
      way.push_back(nearest);
    }
    for (size_t level = 0; level < 5; ++level) {
      const WordOf found = vocabulary.Find(d, static_cast<int>(level));
      EXPECT_EQ(found.node, way[std::min(level, way.size() - 1)]);
      EXPECT_EQ(found.word, nodes[static_cast<size_t>(way.back())].word);
    }
  }
}

TEST(Vocabulary, WeighsWordsByTheImagesTheyAreIn) {
  Rng rng(4);
  const BinaryDescriptor common = RandomDescriptor(rng), rare = RandomDescriptor(rng);
  const Images images = {{common, common, rare}, {common}, {common}, {common}};
  const Vocabulary vocabulary = Vocabulary::Train(images, Small(2, 1), 1);
  const auto weight = [&](const BinaryDescriptor& d) {
    const int32_t word = vocabulary.Find(d, 0).word;
    return vocabulary
        .nodes()[static_cast<size_t>(vocabulary.leaf_of_word()[static_cast<size_t>(word)])]
        .weight;
  };
  EXPECT_EQ(weight(common), 0.0);
  EXPECT_DOUBLE_EQ(weight(rare), std::log(4.0));
  EXPECT_TRUE(vocabulary.Describe(images[1]).empty());
  EXPECT_EQ(vocabulary.Describe(images[0]).size(), 1U);
}

TEST(Vocabulary, SimilarityIsOneMinusHalfTheL1Distance) {
  const Images images = MakeImages(20, 100, 5);
  const Vocabulary vocabulary = Vocabulary::Train(images, Small(5, 3), 1);
  const BagOfWords a = vocabulary.Describe(images[0]), b = vocabulary.Describe(images[1]);
  std::vector<double> difference(static_cast<size_t>(vocabulary.words()), 0.0);
  double sum = 0.0;
  for (const WordShare& w : a) {
    difference[static_cast<size_t>(w.word)] += static_cast<double>(w.share);
    sum += static_cast<double>(w.share);
  }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  for (const WordShare& w : b) {
    difference[static_cast<size_t>(w.word)] -= static_cast<double>(w.share);
  }
  double l1 = 0.0;
  for (const double d : difference) l1 += std::abs(d);
  EXPECT_NEAR(Similarity(a, b), 1.0 - 0.5 * l1, 1e-5);
  EXPECT_NEAR(Similarity(a, a), 1.0, 1e-5);
  EXPECT_EQ(Similarity(a, {}), 0.0);
}

TEST(Vocabulary, RefusesNothingToTrainOnAndBadOptions) {
  EXPECT_THROW(Vocabulary::Train({{}, {}}, {}, 1), InputError);
  const std::vector<BinaryDescriptor> image = MakeImages(1, 5, 8)[0];
  EXPECT_THROW(Vocabulary::Train({image}, {}, 1), InputError);
  EXPECT_THROW(Vocabulary::Train({image, {}}, {}, 1), InputError) << "one image has features";
  EXPECT_THROW(Vocabulary::Train({image, image}, {}, 1), InputError) << "all alike: no weights";
  EXPECT_THROW(Small(1, 4).Check(), InputError);
  EXPECT_THROW(Small(10, 0).Check(), InputError);
  EXPECT_THROW(Small(100, 8).Check(), InputError);
  EXPECT_THROW(Vocabulary(2, 1, {VocabularyNode{}}), Error);
}

TEST(Vocabulary, AWordIsTheMajorityOfItsMembers) {
  Rng rng(7);
  const BinaryDescriptor a = RandomDescriptor(rng), b = RandomDescriptor(rng);
  const std::vector<BinaryDescriptor> members = {a, WithNoise(a, 40, rng), a, b, b};
  const Vocabulary vocabulary = Vocabulary::Train({members, {b}}, Small(2, 1), 1);
  std::set<BinaryDescriptor> words;
  for (const int32_t leaf : vocabulary.leaf_of_word()) {
    words.insert(vocabulary.nodes()[static_cast<size_t>(leaf)].descriptor);
  }
  EXPECT_EQ(words, (std::set<BinaryDescriptor>{a, b}));
}

TEST(Vocabulary, FewDifferentDescriptorsGiveFewWords) {
  Rng rng(6);
  const BinaryDescriptor a = RandomDescriptor(rng), b = RandomDescriptor(rng);
  const Vocabulary vocabulary = Vocabulary::Train({{a, a, b}, {b}}, Small(10, 4), 1);
  EXPECT_EQ(vocabulary.words(), 2);
  EXPECT_EQ(Vocabulary::Train({{a, a, b}, {a, a}}, Small(10, 4), 1).words(), 2);
}

}  // namespace
}  // namespace tvl
