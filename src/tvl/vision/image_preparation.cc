#include "tvl/vision/image_preparation.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Value below which 99.5 % of a 16-bit image lie, from every 4th pixel of every 4th row.
double BrightLevel(const cv::Mat& grey16) {
  std::vector<uint16_t> sample;
  sample.reserve(grey16.total() / 16 + 1);
  for (int y = 0; y < grey16.rows; y += 4) {
    const uint16_t* row = grey16.ptr<uint16_t>(y);
    for (int x = 0; x < grey16.cols; x += 4) sample.push_back(row[x]);
  }
  const auto nth = sample.begin() + static_cast<std::ptrdiff_t>((sample.size() - 1) * 995 / 1000);
  std::nth_element(sample.begin(), nth, sample.end());
  return std::max<double>(1.0, *nth);
}

}  // namespace

void ImagePreparationOptions::Check() const {
  TVL_CHECK_INPUT(clahe_clip > 0.0) << "clahe_clip: must be positive, is " << clahe_clip;
  TVL_CHECK_INPUT(clahe_tiles >= 1) << "clahe_tiles: must be at least 1, is " << clahe_tiles;
  TVL_CHECK_INPUT(min_mean_level >= 0.0)
      << "min_mean_level: must not be negative, is " << min_mean_level;
  TVL_CHECK_INPUT(min_contrast_level >= 0.0)
      << "min_contrast_level: must not be negative, is " << min_contrast_level;
}

cv::Mat ToGrey8(const cv::Mat& image) {
  const int depth = image.depth(), channels = image.channels();
  TVL_CHECK_INPUT((depth == CV_8U || depth == CV_16U) &&
                  (channels == 1 || channels == 3 || channels == 4))
      << "image: must have 8 or 16 bit and 1, 3 or 4 channels, has OpenCV type " << image.type();
  cv::Mat grey = image;
  if (channels == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (channels == 4) cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
  if (depth == CV_8U || image.empty()) return grey;
  cv::Mat grey8;
  grey.convertTo(grey8, CV_8U, 255.0 / BrightLevel(grey));
  return grey8;
}

bool IsUsableImage(const cv::Mat& grey, const ImagePreparationOptions& options) {
  if (grey.empty()) return false;
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey, mean, deviation);
  return mean[0] >= options.min_mean_level && deviation[0] >= options.min_contrast_level;
}

cv::Mat Equalise(const cv::Mat& grey, const ImagePreparationOptions& options) {
  cv::Mat result;
  cv::createCLAHE(options.clahe_clip, cv::Size(options.clahe_tiles, options.clahe_tiles))
      ->apply(grey, result);
  return result;
}

}  // namespace tvl
