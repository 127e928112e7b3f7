#include "tvl/sim/texture_tile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

cv::Mat RandomGrey(int size) {
  Rng rng(3);
  cv::Mat grey(size, size, CV_32F);
  for (int i = 0; i < size * size; ++i) {
    grey.at<float>(i / size, i % size) = static_cast<float>(rng.Uniform());
  }
  return grey;
}

TEST(TextureTile, ReturnsTexelsAtTheirCentres) {
  const cv::Mat grey = RandomGrey(16);
  const TextureTile tile(grey, 1.6F);  // 0.1 m a texel
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const float u = 0.1F * (static_cast<float>(x) + 0.5F);
      const float v = 0.1F * (static_cast<float>(y) + 0.5F);
      EXPECT_NEAR(tile.Sample(u, v, 0.01F), grey.at<float>(y, x), 0.005F);
    }
  }
}

TEST(TextureTile, RepeatsInBothDirectionsAndBelowZero) {
  const TextureTile tile(RandomGrey(16), 1.6F);
  for (const float footprint : {0.05F, 0.13F, 0.4F}) {
    const float value = tile.Sample(0.33F, 1.21F, footprint);
    EXPECT_NEAR(tile.Sample(0.33F - 3.2F, 1.21F, footprint), value, 1e-3F);
    EXPECT_NEAR(tile.Sample(0.33F + 1.6F, 1.21F - 4.8F, footprint), value, 1e-3F);
  }
}

TEST(TextureTile, FadesToTheMeanAsTheFootprintGrows) {
  const cv::Mat grey = RandomGrey(64);
  const TextureTile tile(grey, 6.4F);
  EXPECT_NEAR(tile.Sample(1.0F, 2.0F, 100.0F), static_cast<float>(cv::mean(grey)[0]), 0.01F);
  double last = 1.0;
  for (const float footprint : {0.1F, 0.2F, 0.4F, 0.8F, 1.6F}) {
    cv::Mat values(1, 500, CV_32F);
    for (int i = 0; i < 500; ++i) {
      const auto t = static_cast<float>(i);
      values.at<float>(i) = tile.Sample(0.73F * t, 0.31F * t, footprint);
    }
    cv::Scalar mean, sigma;
    cv::meanStdDev(values, mean, sigma);
    EXPECT_LT(sigma[0], 0.75 * last);
    last = sigma[0];
  }
}

TEST(TextureTile, ElongatedFootprintAveragesAlongItsAxisOnly) {
  cv::Mat stripes(64, 64, CV_32F);  // vary along u, one texel wide
  for (int i = 0; i < 64 * 64; ++i) {
    stripes.at<float>(i / 64, i % 64) = i % 64 < 32 ? 0.0F : 1.0F;
  }
  const TextureTile tile(stripes, 6.4F);
  TextureFootprint along_v{1.6F, 3.0F, 0.0F, 1.2F, 0.1F};
  EXPECT_NEAR(tile.Sample(along_v), 0.0F, 0.01F);
  along_v.u_m = 4.8F;
  EXPECT_NEAR(tile.Sample(along_v), 1.0F, 0.01F);
  const TextureFootprint across{3.2F, 3.0F, 1.2F, 0.0F, 0.1F};
  EXPECT_NEAR(tile.Sample(across), 0.5F, 0.05F);
}

TEST(TextureTile, RefusesOddSizes) {
  EXPECT_THROW(TextureTile(RandomGrey(12), 1.0F), Error);
  EXPECT_THROW(TextureTile(cv::Mat(8, 8, CV_8U), 1.0F), Error);
}

}  // namespace
}  // namespace tvl::sim
