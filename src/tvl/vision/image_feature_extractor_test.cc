#include "tvl/vision/image_feature_extractor.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

Camera TestCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 300.0;
  camera.cx_px = 200.0;
  camera.cy_px = 100.0;
  camera.distortion = {-0.2, 0.05, 0.0, 0.0, 0.0};
  return camera;
}

TEST(ImageFeatureExtractor, GivesAlignedArraysAndUndistortedRays) {
  const Camera camera = TestCamera();
  const ImageFeatures f = ImageFeatureExtractor().Extract(MakeTexture({400, 200}, 1), camera);
  ASSERT_GT(f.size(), 200U);
  ASSERT_EQ(f.px_cam.size(), f.size());
  ASSERT_EQ(f.ray_cam.size(), f.size());
  ASSERT_EQ(f.depth_m.size(), f.size());
  for (size_t i = 0; i < f.size(); ++i) {
    const Eigen::Vector2d back = camera.Project(f.ray_cam[i].cast<double>());
    EXPECT_NEAR((back - f.px_cam[i].cast<double>()).norm(), 0.0, 1e-3);
    EXPECT_EQ(f.depth_m[i], 0.0f);
  }
}

TEST(ImageFeatureExtractor, GreyColourAnd16BitGiveTheSame) {
  const cv::Mat grey = MakeTexture({400, 200}, 2);
  cv::Mat colour, wide;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  grey.convertTo(wide, CV_16U, 16.0);
  const ImageFeatureExtractor extractor;
  const ImageFeatures of_grey = extractor.Extract(grey, TestCamera());
  const ImageFeatures of_colour = extractor.Extract(colour, TestCamera());
  EXPECT_EQ(of_grey.descriptors, of_colour.descriptors);
  EXPECT_EQ(of_grey.px_cam, of_colour.px_cam);
  EXPECT_NEAR(static_cast<double>(extractor.Extract(wide, TestCamera()).size()),
              static_cast<double>(of_grey.size()), 0.1 * static_cast<double>(of_grey.size()));
}

TEST(ImageFeatureExtractor, UnusableImagesHaveNoFeatures) {
  const ImageFeatureExtractor extractor;
  EXPECT_EQ(extractor.Extract(cv::Mat(), TestCamera()).size(), 0U);
  cv::Mat dark;
  MakeTexture({400, 200}, 3).convertTo(dark, CV_8U, 0.005);
  EXPECT_EQ(extractor.Extract(dark, TestCamera()).size(), 0U);
}

TEST(ImageFeatureExtractor, OptionsAreChecked) {
  ImageFeatureOptions options;
  options.corners.count = 0;
  EXPECT_THROW(ImageFeatureExtractor{options}, InputError);
}

}  // namespace
}  // namespace tvl
