// Test images with corners everywhere, and moved versions of them. For tests only.
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "tvl/base/rng.h"

namespace tvl {

// Smoothed blocks of random grey, 8 bit: strong corners about every 12 px.
inline cv::Mat MakeTexture(cv::Size size, uint64_t seed) {
  Rng rng(seed);
  cv::Mat blocks(size.height / 12 + 1, size.width / 12 + 1, CV_8U);
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) {
      blocks.at<uchar>(y, x) = static_cast<uchar>(20 + rng.Integer(216));
    }
  }
  cv::Mat big, smooth;
  cv::resize(blocks, big, {blocks.cols * 12, blocks.rows * 12}, 0, 0, cv::INTER_NEAREST);
  cv::GaussianBlur(big, smooth, {0, 0}, 1.2);
  return smooth(cv::Rect(0, 0, size.width, size.height)).clone();
}

// The image seen after every point moved by M (2x3, p_new = M p): what leaves is lost, what enters
// mirrors what is near.
inline cv::Mat Warp(const cv::Mat& image, const cv::Matx23d& M) {
  cv::Mat result;
  cv::warpAffine(image, result, M, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  return result;
}

inline cv::Mat Shift(const cv::Mat& image, double dx_px, double dy_px) {
  return Warp(image, {1.0, 0.0, dx_px, 0.0, 1.0, dy_px});
}

}  // namespace tvl
