#include "tvl/sim/film.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

FilmOptions Plain() {
  FilmOptions options;
  options.vignetting = 0.0;
  options.exposure_strength = 0.0;
  options.exposure_drift = 0.0;
  return options;
}

cv::Mat Flat(float radiance) { return cv::Mat(200, 300, CV_32F, cv::Scalar(radiance)); }

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

TEST(Film, NoiseHasThePromisedSpread) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(Film(Plain()).Develop(Flat(0.5F), 3, false, Executor(1)), mean, sigma);
  EXPECT_NEAR(mean[0], 127.5, 0.1);
  // sqrt(1.4^2 + 0.5 * 1.8^2), and rounding
  EXPECT_NEAR(sigma[0], 1.92, 0.08);
}

TEST(Film, NoiseDiffersFromFrameToFrameOnly) {
  const Film film(Plain());
  const cv::Mat a = film.Develop(Flat(0.5F), 3, false, Executor(1));
  const cv::Mat b = film.Develop(Flat(0.5F), 3, false, Executor(3));
  const cv::Mat c = film.Develop(Flat(0.5F), 4, false, Executor(1));
  EXPECT_EQ(MeanDifference(a, b), 0.0);
  EXPECT_GT(MeanDifference(a, c), 1.0);
}

TEST(Film, NeighbouringPixelsHaveIndependentNoise) {
  cv::Mat image;
  Film(Plain()).Develop(Flat(0.5F), 3, false, Executor(1)).convertTo(image, CV_32F, 1.0, -127.5);
  for (int shift = 1; shift <= 5; ++shift) {
    const cv::Mat left = image.colRange(0, 300 - shift);
    const cv::Mat right = image.colRange(shift, 300);
    EXPECT_LT(std::abs(cv::mean(left.mul(right))[0]), 0.1);
  }
}

TEST(Film, BlursOverAboutHalfAPixel) {
  FilmOptions options = Plain();
  options.read_noise_grey = options.photon_noise_grey = 0.0;
  cv::Mat point = Flat(0.0F);
  point.at<float>(100, 150) = 1.0F;
  const cv::Mat image = Film(options).Develop(point, 0, false, Executor(1));
  EXPECT_NEAR(image.at<uint8_t>(100, 150) / 255.0, 0.444, 0.01);
  EXPECT_NEAR(image.at<uint8_t>(100, 151) / 255.0, 0.111, 0.01);
  EXPECT_NEAR(image.at<uint8_t>(101, 150) / 255.0, 0.111, 0.01);
  EXPECT_EQ(image.at<uint8_t>(100, 152), 0);
}

TEST(Film, ExposureApproachesTheTarget) {
  FilmOptions options = Plain();
  options.exposure_strength = 1.0;
  const Film film(options);
  for (const float radiance : {0.2F, 0.4F, 0.9F}) {
    const cv::Mat image = film.Develop(Flat(radiance), 0, false, Executor(1));
    EXPECT_NEAR(cv::mean(image)[0] / 255.0, options.target_mean, 0.01);
  }
  EXPECT_LT(cv::mean(film.Develop(Flat(0.01F), 0, false, Executor(1)))[0], 12.0);
}

TEST(Film, NightIsAlmostBlack) {
  EXPECT_LT(cv::mean(Film(Plain()).Develop(Flat(0.8F), 0, true, Executor(1)))[0], 4.0);
}

TEST(Film, RefusesBadOptions) {
  FilmOptions options;
  options.vignetting = 1.0;
  EXPECT_THROW(Film{options}, InputError);
}

}  // namespace
}  // namespace tvl::sim
