#include "tvl/vision/fast_corners.h"

#include <gtest/gtest.h>

#include <map>

#include "tvl/base/check.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

constexpr int kBorder_px = 24;

TEST(FastCorners, KeepDistanceAndBorder) {
  const FastCornersOptions options;
  const std::vector<cv::Point> corners =
      DetectFastCorners(MakeTexture({640, 320}, 1), kBorder_px, options);
  ASSERT_GT(corners.size(), 400U);
  ASSERT_LE(corners.size(), 500U);
  for (size_t i = 0; i < corners.size(); ++i) {
    EXPECT_GE(corners[i].x, kBorder_px);
    EXPECT_GE(corners[i].y, kBorder_px);
    EXPECT_LT(corners[i].x, 640 - kBorder_px);
    EXPECT_LT(corners[i].y, 320 - kBorder_px);
    for (size_t j = 0; j < i; ++j) EXPECT_GT(cv::norm(corners[i] - corners[j]), 5.0);
  }
}

TEST(FastCorners, ATexturedCornerDoesNotTakeThemAll) {
  // Faint texture everywhere, hard texture in one quarter.
  cv::Mat image = MakeTexture({640, 320}, 2);
  cv::Mat faint;
  image.convertTo(faint, CV_8U, 0.25, 90.0);
  image(cv::Rect(0, 0, 320, 160)).copyTo(faint(cv::Rect(0, 0, 320, 160)));
  FastCornersOptions options;
  options.count = 200;
  std::map<std::pair<bool, bool>, int> quarters;
  for (const cv::Point& px : DetectFastCorners(faint, kBorder_px, options)) {
    ++quarters[{px.x >= 320, px.y >= 160}];
  }
  for (const bool right : {false, true}) {
    for (const bool low : {false, true}) EXPECT_GE((quarters[{right, low}]), 25);
  }
}

TEST(FastCorners, StrongestOfACellComeFirst) {
  cv::Mat image(200, 200, CV_8U, cv::Scalar(100));
  image(cv::Rect(60, 60, 20, 20)).setTo(130);
  image(cv::Rect(120, 120, 20, 20)).setTo(250);
  FastCornersOptions options;
  cv::GaussianBlur(image, image, cv::Size(5, 5), 1.0);
  options.cell_px = 200.0;  // one cell
  options.count = 4;
  const std::vector<cv::Point> corners = DetectFastCorners(image, kBorder_px, options);
  ASSERT_EQ(corners.size(), 4U);
  for (const cv::Point& px : corners) EXPECT_GT(px.x, 110);
}

TEST(FastCorners, NothingToFindInFlatOrTinyImages) {
  EXPECT_TRUE(DetectFastCorners(cv::Mat(200, 200, CV_8U, cv::Scalar(7)), kBorder_px, {}).empty());
  EXPECT_TRUE(DetectFastCorners(MakeTexture({40, 40}, 3), kBorder_px, {}).empty());
}

TEST(FastCorners, OptionsAreChecked) {
  FastCornersOptions options;
  options.threshold_levels = 0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.count = 0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.cell_px = 0.0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.min_distance_px = -1.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
