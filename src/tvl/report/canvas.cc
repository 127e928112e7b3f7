#include "tvl/report/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/vision/image_preparation.h"

namespace tvl {
namespace {

constexpr int kBar_px = 26;

// Of a colour wheel angle in degrees (0 red, 120 green, 240 blue), full brightness.
cv::Scalar Hue(double degrees) {
  const auto channel = [&](double centre) {
    const double off = std::abs(std::remainder(degrees - centre, 360.0));
    return 255.0 * std::clamp(2.0 - off / 60.0, 0.0, 1.0);
  };
  return {channel(240.0), channel(120.0), channel(0.0)};
}

}  // namespace

cv::Mat ToCanvas(const cv::Mat& image, double brightness) {
  cv::Mat canvas;
  if (image.depth() == CV_8U && image.channels() == 3) {
    canvas = image;
  } else {
    cv::cvtColor(ToGrey8(image), canvas, cv::COLOR_GRAY2BGR);
  }
  cv::Mat result;
  canvas.convertTo(result, CV_8U, brightness);
  return result;
}

cv::Scalar GreenToRed(double share) { return Hue(120.0 * (1.0 - std::clamp(share, 0.0, 1.0))); }

cv::Scalar NearToFar(double share) { return Hue(240.0 * std::clamp(share, 0.0, 1.0)); }

cv::Mat WithLegend(const cv::Mat& picture, const std::string& caption,
                   const std::vector<LegendEntry>& entries) {
  cv::Mat result(picture.rows + kBar_px, picture.cols, CV_8UC3, cv::Scalar::all(24));
  picture.copyTo(result.rowRange(0, picture.rows));
  const double scale = 0.42;
  const int baseline = picture.rows + 17;
  int x = 8;
  const auto write = [&](const std::string& text) {
    cv::putText(result, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar::all(235),
                1, cv::LINE_AA);
    x += cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, nullptr).width + 16;
  };
  write(caption);
  for (const LegendEntry& entry : entries) {
    cv::circle(result, {x, baseline - 4}, 4, entry.colour, cv::FILLED, cv::LINE_AA);
    x += 9;
    write(entry.text);
  }
  return result;
}

cv::Point ShiftedPoint(const Eigen::Vector2d& px) {
  return {static_cast<int>(std::lround(px.x() * (1 << kShift))),
          static_cast<int>(std::lround(px.y() * (1 << kShift)))};
}

}  // namespace tvl
