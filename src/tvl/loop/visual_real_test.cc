// The shipped vocabulary and the descriptors on real images: simulated ones may flatter.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "tvl/io/test_data.h"
#include "tvl/loop/feature_matching.h"
#include "tvl/loop/visual_database.h"
#include "tvl/loop/vocabulary_file.h"
#include "tvl/vision/image_feature_extractor.h"

namespace tvl {
namespace {

// Every second frame of a drive of about 1 m a frame.
std::vector<ImageFeatures> Describe(const std::string& sequence) {
  Camera camera;
  camera.fx_px = camera.fy_px = 550.0;
  const ImageFeatureExtractor extractor;
  std::vector<ImageFeatures> features;
  for (int i = 0; i < 50; i += 2) {
    const std::string number = std::to_string(i);
    const std::string path =
        sequence + "/image_2/" + std::string(6 - number.size(), '0') + number + ".png";
    const cv::Mat image = cv::imread(path);
    EXPECT_FALSE(image.empty()) << path;
    features.push_back(extractor.Extract(image, camera));
  }
  return features;
}

TEST(VisualReal, NeighboursAreMoreAlikeThanFarPlacesAndTheirFeaturesMatch) {
  const auto sequence = TestDataPath("sequences/kitti360_3000");
  if (!sequence) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real images";
  const std::vector<ImageFeatures> features = Describe(*sequence);
  VisualDatabase database(std::make_shared<const Vocabulary>(DefaultVocabulary()), 1);
  for (const ImageFeatures& f : features) database.Add(f.descriptors);
  int first_place = 0;
  std::vector<size_t> near_matches, far_matches;
  const auto matches = [&](int history, int current) {
    return MatchFeatures(features[static_cast<size_t>(history)], database.direct_index(history),
                         features[static_cast<size_t>(current)], database.direct_index(current), {})
        .size();
  };
  for (int i = 13; i < database.size(); ++i) {
    const std::vector<VisualMatch> all = database.Query(i, i);
    const auto similarity = [&](int keyframe) {
      const auto at = std::find_if(all.begin(), all.end(),
                                   [&](const VisualMatch& m) { return m.keyframe == keyframe; });
      return at == all.end() ? 0.0 : at->similarity;
    };
    double farthest = 0.0;  // 24 m and more back along the same hedge
    for (int j = 0; j <= i - 12; ++j) farthest = std::max(farthest, similarity(j));
    first_place += similarity(i - 1) > farthest ? 1 : 0;
    near_matches.push_back(matches(i - 1, i));
    far_matches.push_back(matches(i - 12, i));
  }
  EXPECT_EQ(first_place, 12);
  std::sort(near_matches.begin(), near_matches.end());
  std::sort(far_matches.begin(), far_matches.end());
  EXPECT_GE(near_matches[6], 60U);  // median
  EXPECT_LE(far_matches[6], 25U);
}

}  // namespace
}  // namespace tvl
