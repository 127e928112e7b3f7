#include "tvl/vision/optical_flow.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/vision/corner_detector.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

const OpticalFlowOptions kOptions;

struct Scene {
  cv::Mat image = MakeTexture({640, 320}, 5);
  ImagePyramid previous{image.clone(), kOptions};
  std::vector<cv::Point2f> corners =
      DetectCorners(previous.gradient(), previous.grey(), {150, {}, {}}, {});
};

TEST(OpticalFlow, FollowsSubPixelMotion) {
  const Scene scene;
  const ImagePyramid current(Shift(scene.image, 7.3, -4.6), kOptions);
  const auto flow = TrackPoints(scene.previous, current, scene.corners, {}, kOptions);
  int tracked = 0;
  for (size_t i = 0; i < flow.size(); ++i) {
    if (flow[i].status != FlowStatus::kTracked) continue;
    const cv::Point2f step = flow[i].px - scene.corners[i];
    tracked += std::abs(step.x - 7.3f) < 0.1f && std::abs(step.y + 4.6f) < 0.1f;
  }
  EXPECT_GT(tracked, 130);
}

TEST(OpticalFlow, BackwardCheckRejectsWhatIsNotThereAnyMore) {
  const Scene scene;
  const ImagePyramid other(MakeTexture({640, 320}, 6), kOptions);
  const auto flow = TrackPoints(scene.previous, other, scene.corners, {}, kOptions);
  int tracked = 0;
  for (const FlowPoint& p : flow) tracked += p.status == FlowStatus::kTracked;
  EXPECT_LT(tracked, 30) << "nearly nothing of an unrelated image passes";
}

TEST(OpticalFlow, SeedsReachFartherThanTheSearch) {
  const Scene scene;
  const double dx_px = 150.0;
  const ImagePyramid current(Shift(scene.image, dx_px, 0.0), kOptions);
  const auto good = [&](const std::vector<FlowSeed>& seeds) {
    const auto flow = TrackPoints(scene.previous, current, scene.corners, seeds, kOptions);
    int count = 0;
    for (size_t i = 0; i < flow.size(); ++i) {
      count += flow[i].status == FlowStatus::kTracked &&
               std::abs(flow[i].px.x - scene.corners[i].x - dx_px) < 0.2;
    }
    return count;
  };
  std::vector<FlowSeed> seeds;
  for (const cv::Point2f& c : scene.corners) seeds.push_back({{c.x + 145.0f, c.y + 3.0f}, true});
  EXPECT_LT(good({}), 40);
  EXPECT_GT(good(seeds), 90);  // of those that stay inside
}

TEST(OpticalFlow, WrongSeedsFallBackToTheWideSearch) {
  const Scene scene;
  const ImagePyramid current(Shift(scene.image, 3.0, 2.0), kOptions);
  std::vector<FlowSeed> seeds;
  for (const cv::Point2f& c : scene.corners) seeds.push_back({{c.x + 200.0f, c.y}, true});
  const auto flow = TrackPoints(scene.previous, current, scene.corners, seeds, kOptions);
  int good = 0;
  for (size_t i = 0; i < flow.size(); ++i) {
    good += flow[i].status == FlowStatus::kTracked &&
            std::abs(flow[i].px.x - scene.corners[i].x - 3.0f) < 0.2f;
  }
  EXPECT_GT(good, 120);
}

TEST(ImagePyramid, CopiesShareNothing) {
  const ImagePyramid original(MakeTexture({200, 100}, 7), kOptions);
  const ImagePyramid copy = original;
  EXPECT_NE(copy.grey().data, original.grey().data);
  EXPECT_NE(copy.levels().front().data, original.levels().front().data);
  EXPECT_EQ(cv::norm(copy.levels()[2], original.levels()[2], cv::NORM_INF), 0.0);
  EXPECT_TRUE(ImagePyramid(ImagePyramid()).empty());
}

// A part of an odd-sized image, in its corner: flow there is that of the whole image.
TEST(ImagePyramid, FlowInAPartIsThatOfTheWhole) {
  const cv::Mat before = MakeTexture({201, 121}, 7);
  cv::Mat after;
  cv::warpAffine(before, after, cv::Matx23d(1, 0, 1.3, 0, 1, -0.6), before.size(), cv::INTER_CUBIC,
                 cv::BORDER_REFLECT_101);
  const ImagePyramid previous(before, kOptions), current(after, kOptions);
  const cv::Rect area(100, 60, 100, 60);
  const std::vector<cv::Point2f> in_image = {{140.0f, 90.0f}, {150.5f, 84.0f}, {160.0f, 100.0f}};
  std::vector<cv::Point2f> in_area;
  for (const cv::Point2f& px : in_image) in_area.emplace_back(px.x - 100.0f, px.y - 60.0f);
  OpticalFlowOptions near = kOptions;
  near.max_level = near.seeded_level;
  const std::vector<FlowPoint> whole = TrackPoints(previous, current, in_image, {}, near);
  const std::vector<FlowPoint> part = TrackPoints(
      previous.Part(area, near.max_level), current.Part(area, near.max_level), in_area, {}, near);
  for (size_t i = 0; i < in_image.size(); ++i) {
    ASSERT_EQ(whole[i].status, FlowStatus::kTracked);
    ASSERT_EQ(part[i].status, FlowStatus::kTracked);
    EXPECT_NEAR(part[i].px.x + 100.0f, whole[i].px.x, 0.01f);
    EXPECT_NEAR(part[i].px.y + 60.0f, whole[i].px.y, 0.01f);
  }
  EXPECT_THROW(previous.Part(cv::Rect(101, 60, 90, 40), 1), Error);
}

TEST(OpticalFlow, CheckNamesTheField) {
  OpticalFlowOptions options;
  options.window_px = 20;
  EXPECT_THROW(options.Check(), InputError);
  EXPECT_NO_THROW(kOptions.Check());
}

}  // namespace
}  // namespace tvl
