#include "tvl/io/image_file.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace tvl {
namespace {

using Kind = FrameFault::Kind;

cv::Mat Decode(const std::string& path) {
  try {
    cv::Mat image = cv::imread(path, cv::IMREAD_UNCHANGED);
    if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
    const bool known = (image.depth() == CV_8U || image.depth() == CV_16U) &&
                       (image.channels() == 1 || image.channels() == 3);
    return known ? image : cv::Mat();
  } catch (const cv::Exception&) {
    return {};
  }
}

bool IsBlack(const cv::Mat& image) {
  const cv::Scalar mean = cv::mean(image);
  double brightest = 0.0;
  for (int c = 0; c < image.channels(); ++c) brightest = std::max(brightest, mean[c]);
  return brightest <= kBlackShare * (image.depth() == CV_8U ? 255.0 : 4095.0);
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

ImageRead ReadImage(const std::string& path, int width_px, int height_px) {
  return CheckImage(Decode(path), path, width_px, height_px);
}

ImageRead CheckImage(const cv::Mat& image, const std::string& source, int width_px, int height_px) {
  if (image.empty()) {
    return {{}, {{Kind::kUnreadableImage, source + ": not a readable 8 or 16 bit image"}}};
  }
  if (width_px > 0 && (image.cols != width_px || image.rows != height_px)) {
    return {{},
            {{Kind::kWrongSizeImage, source + ": is " + SizeText(image.cols, image.rows) +
                                         ", the others are " + SizeText(width_px, height_px)}}};
  }
  if (IsBlack(image)) return {{}, {{Kind::kBlackImage, source + ": black"}}};
  return {image, {}};
}

}  // namespace tvl
