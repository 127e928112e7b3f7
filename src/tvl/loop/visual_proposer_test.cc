#include "tvl/loop/visual_proposer.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

Calibration TestCalibration() {
  Calibration calibration;
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.T_cam_lidar = Rigid3d(R, {0.05, -0.08, -0.27});
  return calibration;
}

// Straight on along the camera's z axis, a place every metre: neighbours share points.
class VisualProposerTest : public testing::Test {
 protected:
  VisualProposerTest() {
    Rng rng(1);
    for (uint64_t i = 0; i < 60; ++i) {  // chunks of road, 1 m each
      chunks_.push_back(MakePlace(12, 100 + i));
      for (PlacePoint& p : chunks_.back()) {
        p.p_world.z() = static_cast<double>(i) + rng.Uniform();
      }
    }
    std::vector<std::vector<BinaryDescriptor>> images;
    for (int i = 0; i < 40; ++i)
      images.push_back(At(i, 0.0, 500 + static_cast<uint64_t>(i)).descriptors);
    VocabularyOptions options;
    options.branching = 9;
    options.levels = 3;
    vocabulary_ = std::make_shared<Vocabulary>(Vocabulary::Train(images, options, 1));
  }

  // The camera at `way_m` on that road, `side_m` to the right.
  ImageFeatures At(double way_m, double side_m, uint64_t seed) const {
    Place ahead;
    const auto first = static_cast<size_t>(way_m + 5.0);
    for (size_t i = first; i < std::min(first + 15, chunks_.size()); ++i) {
      ahead.insert(ahead.end(), chunks_[i].begin(), chunks_[i].end());
    }
    return See(ahead, Rigid3d::Translation(side_m, 0, way_m), 0.5, seed);
  }

  void Add(VisualProposer& proposer, ImageFeatures features) {
    features_.push_back(std::make_shared<ImageFeatures>(std::move(features)));
    proposer.Add(*features_.back());
  }

  // 40 keyframes along the road, then `again` of them from 10 m on, half a metre aside.
  VisualProposer DriveTwice(int again, const VisualProposerOptions& options = {}) {
    VisualProposer proposer(vocabulary_, TestCalibration(), options);
    for (int i = 0; i < 40; ++i) Add(proposer, At(i, 0.0, static_cast<uint64_t>(i)));
    for (int i = 0; i < again; ++i) {
      Add(proposer, At(10.3 + i, 0.5, 1000 + static_cast<uint64_t>(i)));
    }
    return proposer;
  }

  VisualProposer::FeatureSource Source() const {
    return [this](int i) { return features_.at(static_cast<size_t>(i)); };
  }

  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<Place> chunks_;
  std::vector<std::shared_ptr<const ImageFeatures>> features_;
};

TEST_F(VisualProposerTest, FindsThePlaceAndThePoseInLidarFrames) {
  const VisualProposer proposer = DriveTwice(6);
  const auto long_ago = [](int h) { return h < 25; };
  for (const int current : {41, 43, 45}) {
    const VisualProposals result = proposer.Propose(current, Source(), long_ago);
    ASSERT_EQ(result.proposals.size(), 1U) << current;
    const LoopProposal& p = result.proposals[0];
    EXPECT_EQ(p.current, current);
    EXPECT_NEAR(p.history, current - 30, 1);
    EXPECT_EQ(p.proposer, LoopProposer::kVisual);
    EXPECT_EQ(p.guess, LoopGuess::kPose);
    EXPECT_GE(p.matches, 25);
    EXPECT_GT(p.score, 0.25);
    // Lidar x is the camera's z, lidar y its -x; the levers cancel without rotation.
    const Eigen::Vector3d want(10.3 + (current - 40) - p.history, -0.5, 0.0);
    EXPECT_LT((p.T_history_current.t() - want).norm(), 0.15);
    EXPECT_LT(p.T_history_current.RotationAngle(), 0.01);
  }
}

TEST_F(VisualProposerTest, OnlyWhatMayMatchIsProposed) {
  const VisualProposer proposer = DriveTwice(4);
  const auto elsewhere = [](int h) { return h >= 30 && h < 35; };
  EXPECT_TRUE(proposer.Propose(43, Source(), elsewhere).proposals.empty());
  EXPECT_TRUE(proposer.Propose(43, Source(), [](int) { return false; }).candidates.empty());
}

TEST_F(VisualProposerTest, TheFirstSightOfAPlaceWaitsForASecond) {
  VisualProposerOptions options;
  options.min_relative_similarity = 0.4;  // above what strangers share in a small vocabulary
  const VisualProposer proposer = DriveTwice(2, options);
  const auto long_ago = [](int h) { return h < 25; };
  const VisualProposals first = proposer.Propose(40, Source(), long_ago);
  EXPECT_TRUE(first.proposals.empty());
  ASSERT_FALSE(first.candidates.empty());
  EXPECT_EQ(first.candidates[0].verdict, VisualVerdict::kNotConsistent);
  EXPECT_EQ(proposer.Propose(41, Source(), long_ago).proposals.size(), 1U);
}

TEST_F(VisualProposerTest, WhatLooksAlikeButDoesNotFitIsRefused) {
  VisualProposer proposer(vocabulary_, TestCalibration());
  for (int i = 0; i < 40; ++i) Add(proposer, At(i, 0.0, static_cast<uint64_t>(i)));
  for (int i = 0; i < 3; ++i) {
    ImageFeatures scrambled = At(10.0 + i, 0.0, 1000 + static_cast<uint64_t>(i));
    Rng rng(static_cast<uint64_t>(i));
    for (auto& ray : scrambled.ray_cam) {
      ray = Eigen::Vector2d(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.2, 0.2)).cast<float>();
    }
    Add(proposer, std::move(scrambled));
  }
  const VisualProposals result = proposer.Propose(42, Source(), [](int h) { return h < 25; });
  EXPECT_TRUE(result.proposals.empty());
  ASSERT_FALSE(result.candidates.empty());
  EXPECT_EQ(result.candidates[0].verdict, VisualVerdict::kFewInliers);
}

TEST_F(VisualProposerTest, WithoutDepthThereIsNoPose) {
  VisualProposer proposer(vocabulary_, TestCalibration());
  for (int i = 0; i < 43; ++i) {
    ImageFeatures f = At(i < 40 ? i : i - 30, 0.0, static_cast<uint64_t>(i));
    f.depth_m.assign(f.size(), 0.0f);
    Add(proposer, std::move(f));
  }
  const VisualProposals result = proposer.Propose(42, Source(), [](int h) { return h < 25; });
  ASSERT_FALSE(result.candidates.empty());
  EXPECT_EQ(result.candidates[0].verdict, VisualVerdict::kFewMatches);
  EXPECT_STREQ(ToString(result.candidates[0].verdict), "few_matches");
}

TEST_F(VisualProposerTest, DarkKeyframesMatchNothing) {
  VisualProposer proposer(vocabulary_, TestCalibration());
  for (int i = 0; i < 10; ++i) Add(proposer, ImageFeatures());
  EXPECT_TRUE(proposer.Propose(0, Source(), [](int) { return true; }).candidates.empty());
  EXPECT_TRUE(proposer.Propose(9, Source(), [](int) { return true; }).candidates.empty());
}

TEST_F(VisualProposerTest, AnswersDoNotDependOnWhatWasAskedBefore) {
  const VisualProposer proposer = DriveTwice(4);
  const auto long_ago = [](int h) { return h < 25; };
  const VisualProposals fresh = proposer.Propose(43, Source(), long_ago);
  proposer.Propose(20, Source(), long_ago);
  const VisualProposals again = proposer.Propose(43, Source(), long_ago);
  ASSERT_EQ(fresh.proposals.size(), again.proposals.size());
  ASSERT_EQ(fresh.proposals.size(), 1U);
  EXPECT_EQ(fresh.proposals[0].T_history_current.Matrix(),
            again.proposals[0].T_history_current.Matrix());
}

TEST_F(VisualProposerTest, OptionsAreChecked) {
  VisualProposerOptions options;
  options.min_relative_similarity = 0.0;
  EXPECT_THROW(VisualProposer(vocabulary_, {}, options), InputError);
  options = {};
  options.min_consistent = 0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.pnp.min_inliers = 0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
