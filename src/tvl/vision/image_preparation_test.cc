#include "tvl/vision/image_preparation.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

TEST(ImagePreparation, TakesGreyColourAnd16Bit) {
  const cv::Mat grey = MakeTexture({320, 200}, 1);
  cv::Mat bgr, bgra, deep;
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  cv::cvtColor(grey, bgra, cv::COLOR_GRAY2BGRA);
  grey.convertTo(deep, CV_16U, 16.0);  // a 12-bit sensor
  EXPECT_EQ(cv::norm(ToGrey8(grey), grey, cv::NORM_INF), 0.0);
  EXPECT_LE(cv::norm(ToGrey8(bgr), grey, cv::NORM_INF), 1.0);
  EXPECT_LE(cv::norm(ToGrey8(bgra), grey, cv::NORM_INF), 1.0);
  const cv::Mat from_deep = ToGrey8(deep);
  EXPECT_EQ(from_deep.type(), CV_8UC1);
  // Scaled to fill the range: brighter than the original, the same picture otherwise.
  cv::Scalar mean, deviation;
  cv::meanStdDev(from_deep, mean, deviation);
  EXPECT_GT(deviation[0], 20.0);
}

TEST(ImagePreparation, RefusesOtherTypes) {
  EXPECT_THROW(ToGrey8(cv::Mat(10, 10, CV_32F)), InputError);
  EXPECT_THROW(ToGrey8(cv::Mat(10, 10, CV_8UC2)), InputError);
}

TEST(ImagePreparation, KnowsUnusableImages) {
  const ImagePreparationOptions options;
  EXPECT_FALSE(IsUsableImage(cv::Mat(), options));
  EXPECT_FALSE(IsUsableImage(cv::Mat(100, 100, CV_8U, cv::Scalar(0)), options));
  EXPECT_FALSE(IsUsableImage(cv::Mat(100, 100, CV_8U, cv::Scalar(255)), options));
  EXPECT_TRUE(IsUsableImage(MakeTexture({100, 100}, 2), options));
}

TEST(ImagePreparation, EqualisingRaisesContrastInShadow) {
  cv::Mat shadow;
  MakeTexture({320, 200}, 3).convertTo(shadow, CV_8U, 0.1);
  cv::Scalar mean, before, after;
  cv::meanStdDev(shadow, mean, before);
  cv::meanStdDev(Equalise(shadow, {}), mean, after);
  EXPECT_GT(after[0], 1.5 * before[0]);
}

TEST(ImagePreparation, CheckNamesTheField) {
  ImagePreparationOptions options;
  options.clahe_tiles = 0;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("clahe_tiles"), std::string::npos);
  }
}

}  // namespace
}  // namespace tvl
