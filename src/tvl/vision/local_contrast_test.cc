#include "tvl/vision/local_contrast.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tvl/vision/corner_detector.h"
#include "tvl/vision/image_preparation.h"
#include "tvl/vision/optical_flow.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

// A textured street under a blank sky, with noise of `noise` levels all over it.
cv::Mat StreetUnderSky(double noise) {
  cv::Mat image(400, 800, CV_8U, cv::Scalar(200));
  MakeTexture({800, 250}, 3).copyTo(image.rowRange(150, 400));
  cv::Mat shifted;
  image.convertTo(shifted, CV_16S);
  cv::Mat noise_map(image.size(), CV_16S);
  cv::RNG rng(5);
  rng.fill(noise_map, cv::RNG::NORMAL, 0.0, noise);
  shifted += noise_map;
  shifted.convertTo(image, CV_8U);
  return image;
}

std::vector<cv::Point2f> Corners(const cv::Mat& grey) {
  const cv::Mat equalised = Equalise(grey, {});
  return DetectCorners(ImagePyramid(equalised, {}).gradient(), grey, {300, {}, {}}, {});
}

TEST(LocalContrast, NoiseIsMeasuredWhereNothingElseIs) {
  for (const double noise : {1.0, 2.0, 4.0}) {
    EXPECT_NEAR(NoiseLevel(StreetUnderSky(noise)), noise, 0.35 * noise) << noise;
  }
  EXPECT_EQ(NoiseLevel(cv::Mat(100, 100, CV_8U, cv::Scalar(255))), 0.0);
}

TEST(LocalContrast, IsThatOfThePatchAlone) {
  cv::Mat image(40, 40, CV_8U, cv::Scalar(100));
  image.colRange(20, 40).setTo(cv::Scalar(120));
  EXPECT_NEAR(ContrastAround(image, {20.0f, 20.0f}), 10.0, 0.2);
  EXPECT_EQ(ContrastAround(image, {5.0f, 5.0f}), 0.0);
  EXPECT_EQ(ContrastAround(image, {0.0f, 39.0f}), 0.0);
}

// Equalisation makes corners of the sky's noise; they must not be taken.
TEST(LocalContrast, NoCornersOnABlankSky) {
  for (const double noise : {1.0, 2.0, 4.0}) {
    int sky = 0;
    const std::vector<cv::Point2f> corners = Corners(StreetUnderSky(noise));
    for (const cv::Point2f& corner : corners) sky += corner.y < 140.0f;
    EXPECT_EQ(sky, 0) << "noise " << noise;
    EXPECT_GT(corners.size(), 100U) << "noise " << noise;
  }
}

TEST(LocalContrast, DullTextureStillGivesCorners) {
  cv::Mat dull = MakeTexture({800, 400}, 9);
  dull.convertTo(dull, CV_8U, 0.15, 20.0);  // a street at night
  EXPECT_GT(Corners(dull).size(), 150U);
}

}  // namespace
}  // namespace tvl
