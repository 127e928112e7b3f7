#include "tvl/loop/visual_database.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

std::vector<BinaryDescriptor> RandomImage(int features, Rng& rng) {
  std::vector<BinaryDescriptor> image;
  for (int i = 0; i < features; ++i) image.push_back(RandomDescriptor(rng));
  return image;
}

class VisualDatabaseTest : public testing::Test {
 protected:
  VisualDatabaseTest() {
    Rng rng(1);
    std::vector<std::vector<BinaryDescriptor>> images;
    for (int i = 0; i < 30; ++i) images.push_back(RandomImage(100, rng));
    VocabularyOptions options;
    options.branching = 6;
    options.levels = 3;
    vocabulary_ = std::make_shared<Vocabulary>(Vocabulary::Train(images, options, 1));
  }
  std::shared_ptr<const Vocabulary> vocabulary_;
};

TEST_F(VisualDatabaseTest, QueriesEqualBruteForce) {
  VisualDatabase database(vocabulary_, 1);
  Rng rng(2);
  std::vector<std::vector<BinaryDescriptor>> images;
  for (int i = 0; i < 60; ++i) {
    images.push_back(i == 17 ? std::vector<BinaryDescriptor>() : RandomImage(40, rng));
    database.Add(images.back());
  }
  ASSERT_EQ(database.size(), 60);
  size_t compared = 0;
  for (const int query : {0, 17, 30, 59}) {
    for (const int end : {0, 10, 59}) {
      const std::vector<VisualMatch> matches = database.Query(query, end);
      size_t next = 0;
      for (int i = 0; i < end; ++i) {
        const double expected =
            Similarity(vocabulary_->Describe(images[static_cast<size_t>(query)]),
                       vocabulary_->Describe(images[static_cast<size_t>(i)]));
        if (expected == 0.0) continue;
        ASSERT_LT(next, matches.size());
        EXPECT_EQ(matches[next].keyframe, i);
        EXPECT_NEAR(matches[next].similarity, expected, 1e-5);
        ++next;
      }
      EXPECT_EQ(next, matches.size());
      compared += next;
    }
  }
  EXPECT_GT(compared, 100U);
}

TEST_F(VisualDatabaseTest, TheSameImageIsTheMostAlike) {
  VisualDatabase database(vocabulary_, 1);
  Rng rng(3);
  std::vector<BinaryDescriptor> twelfth;
  for (int i = 0; i < 20; ++i) {
    const auto image = RandomImage(80, rng);
    if (i == 12) twelfth = image;
    database.Add(image);
  }
  database.Add(twelfth);
  double best = 0.0;
  int at = -1;
  for (const VisualMatch& m : database.Query(20, 20)) {
    if (m.similarity > best) {
      best = m.similarity;
      at = m.keyframe;
    }
  }
  EXPECT_EQ(at, 12);
  EXPECT_NEAR(best, 1.0, 1e-5);
}

TEST_F(VisualDatabaseTest, DirectIndexListsEveryFeatureUnderItsNode) {
  VisualDatabase database(vocabulary_, 2);
  Rng rng(4);
  const auto image = RandomImage(90, rng);
  database.Add(image);
  const DirectIndex& index = database.direct_index(0);
  ASSERT_EQ(index.node.size(), 90U);
  ASSERT_EQ(index.feature.size(), 90U);
  std::vector<bool> seen(90, false);
  for (size_t i = 0; i < 90; ++i) {
    EXPECT_EQ(index.node[i], vocabulary_->Find(image[index.feature[i]], 2).node);
    EXPECT_LE(index.node[i == 0 ? 0 : i - 1], index.node[i]);
    seen[index.feature[i]] = true;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 90);
}

TEST_F(VisualDatabaseTest, CountsItsMemoryAndRefusesNonsense) {
  VisualDatabase database(vocabulary_, 1);
  Rng rng(5);
  for (int i = 0; i < 50; ++i) database.Add(RandomImage(100, rng));
  EXPECT_GT(database.StateBytes(), 50U * 100U * 14U);
  EXPECT_LT(database.StateBytes(), 50U * 100U * 40U);
  EXPECT_THROW(database.Query(3, 51), Error);
}

}  // namespace
}  // namespace tvl
