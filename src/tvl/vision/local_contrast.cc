#include "tvl/vision/local_contrast.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tvl {

double ContrastAround(const cv::Mat& grey, const cv::Point2f& px) {
  constexpr int kHalf_px = kContrastPatch_px / 2;
  const int x = static_cast<int>(std::lround(px.x)), y = static_cast<int>(std::lround(px.y));
  const int x0 = std::max(0, x - kHalf_px), x1 = std::min(grey.cols - 1, x + kHalf_px);
  const int y0 = std::max(0, y - kHalf_px), y1 = std::min(grey.rows - 1, y + kHalf_px);
  if (x0 > x1 || y0 > y1) return 0.0;
  int64_t sum = 0, sum_sq = 0;
  for (int v = y0; v <= y1; ++v) {
    const uchar* row = grey.ptr<uchar>(v);
    for (int u = x0; u <= x1; ++u) {
      sum += row[u];
      sum_sq += row[u] * row[u];
    }
  }
  const double n = static_cast<double>((x1 - x0 + 1) * (y1 - y0 + 1));
  const double mean = static_cast<double>(sum) / n;
  return std::sqrt(std::max(0.0, static_cast<double>(sum_sq) / n - mean * mean));
}

double NoiseLevel(const cv::Mat& grey) {
  constexpr int kStep_px = 4 * kContrastPatch_px;  // some 300 patches in an image of KITTI's size
  std::vector<double> contrasts;
  for (int y = kContrastPatch_px; y < grey.rows; y += kStep_px) {
    for (int x = kContrastPatch_px; x < grey.cols; x += kStep_px) {
      const cv::Point2f px(static_cast<float>(x), static_cast<float>(y));
      const double contrast = ContrastAround(grey, px);
      if (contrast > 0.0) contrasts.push_back(contrast);
    }
  }
  if (contrasts.empty()) return 0.0;
  const auto tenth = contrasts.begin() + static_cast<std::ptrdiff_t>(contrasts.size() / 10);
  std::nth_element(contrasts.begin(), tenth, contrasts.end());
  return std::min(kMaxNoise_levels, *tenth);
}

}  // namespace tvl
