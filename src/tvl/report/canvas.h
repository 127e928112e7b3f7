// What the pictures of this folder share.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace tvl {

// An 8-bit BGR copy of an image of any kind the tracker takes; `brightness` scales it, so that
// marks stand out on it.
cv::Mat ToCanvas(const cv::Mat& image, double brightness = 1.0);

// Colour (BGR) of a share in 0..1, clamped. Green over yellow to red, as the paper's Fig. 3.
cv::Scalar GreenToRed(double share);
// Near (0) red over green to far (1) blue.
cv::Scalar NearToFar(double share);

struct LegendEntry {
  cv::Scalar colour;
  std::string text;
};

// Adds a bar below the picture with a caption and a coloured dot and text for each entry.
cv::Mat WithLegend(const cv::Mat& picture, const std::string& caption,
                   const std::vector<LegendEntry>& entries);

// OpenCV pixel with `shift` 4 fractional bits, for sub-pixel drawing (pass kShift to
// cv::circle...).
inline constexpr int kShift = 4;
cv::Point ShiftedPoint(const Eigen::Vector2d& px);

}  // namespace tvl
