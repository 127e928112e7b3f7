#include "tvl/vision/corner_detector.h"

#include <gtest/gtest.h>

#include "tvl/vision/optical_flow.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

std::vector<cv::Point2f> Detect(const cv::Mat& image, const std::vector<cv::Point2f>& occupied_px,
                                int count, const CornerDetectorOptions& options) {
  return DetectCorners(ImagePyramid(image, {}).gradient(), image, {count, occupied_px, {}},
                       options);
}

TEST(CornerDetector, FindsTheCornersOfASquare) {
  cv::Mat image(200, 300, CV_8U, cv::Scalar(60));
  cv::rectangle(image, cv::Rect(100, 60, 80, 70), cv::Scalar(200), cv::FILLED);
  const auto corners = Detect(image, {}, 10, {});
  ASSERT_EQ(corners.size(), 4u);
  for (const cv::Point2f& c : corners) {
    EXPECT_LT(std::min(std::abs(c.x - 99.5f), std::abs(c.x - 179.5f)), 1.5f);
    EXPECT_LT(std::min(std::abs(c.y - 59.5f), std::abs(c.y - 129.5f)), 1.5f);
  }
}

TEST(CornerDetector, KeepsDistanceFromEachOtherAndFromWhatIsThere) {
  const CornerDetectorOptions options;
  const cv::Mat image = MakeTexture({640, 320}, 11);
  std::vector<cv::Point2f> all = Detect(image, {}, 100, options);
  const auto more = Detect(image, all, 60, options);
  EXPECT_EQ(all.size(), 100u);
  EXPECT_GT(more.size(), 40u);
  all.insert(all.end(), more.begin(), more.end());
  for (size_t i = 0; i < all.size(); ++i) {
    for (size_t j = i + 1; j < all.size(); ++j) {
      EXPECT_GE(cv::norm(all[i] - all[j]), options.min_distance_px - 1e-3);
    }
  }
}

// Half of the image has ten times the contrast: without shares it would take nearly all.
TEST(CornerDetector, SpreadsOverTheImage) {
  cv::Mat image = MakeTexture({800, 400}, 12);
  cv::Mat right = image(cv::Rect(400, 0, 400, 400));
  right.convertTo(right, CV_8U, 0.3, 80.0);
  CornerDetectorOptions options;
  const auto count_right = [&] {
    int n = 0;
    for (const cv::Point2f& c : Detect(image, {}, 120, options)) n += c.x > 405.0f;
    return n;
  };
  EXPECT_GT(count_right(), 40);
  options.cell_px = 4000.0;  // one cell: no shares
  EXPECT_LT(count_right(), 20);
}

TEST(CornerDetector, NothingInAUniformOrTinyImage) {
  EXPECT_TRUE(Detect(cv::Mat(100, 100, CV_8U, cv::Scalar(90)), {}, 50, {}).empty());
  EXPECT_TRUE(Detect(cv::Mat(5, 5, CV_8U, cv::Scalar(90)), {}, 50, {}).empty());
  EXPECT_TRUE(Detect(MakeTexture({100, 100}, 1), {}, 0, {}).empty());
}

TEST(CornerDetector, TheStrongestIsThatInTheMask) {
  cv::Mat image(200, 300, CV_8U, cv::Scalar(60));
  cv::rectangle(image, cv::Rect(20, 60, 80, 70), cv::Scalar(250), cv::FILLED);
  cv::rectangle(image, cv::Rect(180, 60, 80, 70), cv::Scalar(74), cv::FILLED);
  cv::Mat noise(image.size(), CV_8U);
  cv::RNG rng(5);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 3);
  image += noise;
  CornerSearch search;
  search.count = 10;
  const cv::Mat gradient = ImagePyramid(image, {}).gradient();
  for (const cv::Point2f& c : DetectCorners(gradient, image, search, {})) {
    EXPECT_LT(c.x, 150.0f) << "the faint square is below the quality of the bright one";
  }
  search.mask = cv::Mat::zeros(image.size(), CV_8U);
  search.mask(cv::Rect(150, 0, 150, 200)).setTo(1);
  const std::vector<cv::Point2f> corners = DetectCorners(gradient, image, search, {});
  EXPECT_GE(corners.size(), 4u);
  for (const cv::Point2f& c : corners) EXPECT_GT(c.x, 150.0f);
}

}  // namespace
}  // namespace tvl
