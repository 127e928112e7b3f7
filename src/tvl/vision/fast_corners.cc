#include "tvl/vision/fast_corners.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Corners inside the border, strongest first; ties by position, so that the order is total.
std::vector<cv::KeyPoint> Candidates(const cv::Mat& grey, int border_px, int threshold) {
  const cv::Rect inside(border_px, border_px, grey.cols - 2 * border_px, grey.rows - 2 * border_px);
  std::vector<cv::KeyPoint> corners;
  if (inside.width <= 0 || inside.height <= 0) return corners;
  cv::FAST(grey, corners, threshold, true);
  const auto outside = [&](const cv::KeyPoint& c) { return !inside.contains(cv::Point(c.pt)); };
  corners.erase(std::remove_if(corners.begin(), corners.end(), outside), corners.end());
  std::sort(corners.begin(), corners.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    return a.pt.y != b.pt.y ? a.pt.y < b.pt.y : a.pt.x < b.pt.x;
  });
  return corners;
}

// Pixels closer than the distance to a chosen corner.
class Taken {
 public:
  Taken(cv::Size image, double distance_px)
      : mask_(image, CV_8U, cv::Scalar(0)), radius_px_(static_cast<int>(distance_px)) {
    const int r = radius_px_;
    for (int y = -r; y <= r; ++y) {
      half_width_px_.push_back(
          static_cast<int>(std::sqrt(std::max(0.0, distance_px * distance_px - y * y))));
    }
  }
  bool Contains(const cv::Point& px) const { return mask_.at<uchar>(px) != 0; }
  void Add(const cv::Point& px) {
    for (int dy = -radius_px_; dy <= radius_px_; ++dy) {
      const int y = px.y + dy, half = half_width_px_[static_cast<size_t>(dy + radius_px_)];
      if (y < 0 || y >= mask_.rows) continue;
      const int begin = std::max(0, px.x - half), end = std::min(mask_.cols, px.x + half + 1);
      std::fill(mask_.ptr<uchar>(y) + begin, mask_.ptr<uchar>(y) + end, uchar{1});
    }
  }

 private:
  cv::Mat mask_;
  int radius_px_;
  std::vector<int> half_width_px_;
};

// Equal shares of the corners for the cells of a coarse grid.
class CellShares {
 public:
  CellShares(cv::Size image, double cell_px, int count)
      : image_(image),
        columns_(std::max(1, static_cast<int>(std::lround(image.width / cell_px)))),
        rows_(std::max(1, static_cast<int>(std::lround(image.height / cell_px)))),
        share_((count + columns_ * rows_ - 1) / (columns_ * rows_)),
        held_(static_cast<size_t>(columns_ * rows_), 0) {}

  bool HasRoom(const cv::Point& px) const { return held_[Cell(px)] < share_; }
  void Add(const cv::Point& px) { ++held_[Cell(px)]; }

 private:
  size_t Cell(const cv::Point& px) const {
    return static_cast<size_t>(px.y * rows_ / image_.height * columns_ +
                               px.x * columns_ / image_.width);
  }

  cv::Size image_;
  int columns_, rows_, share_;
  std::vector<int> held_;
};

}  // namespace

void FastCornersOptions::Check() const {
  TVL_CHECK_INPUT(count >= 1) << "count: must be at least 1, is " << count;
  TVL_CHECK_INPUT(threshold_levels >= 1 && threshold_levels <= 254)
      << "threshold_levels: must lie in 1..254, is " << threshold_levels;
  TVL_CHECK_INPUT(cell_px >= 1.0) << "cell_px: must be at least 1, is " << cell_px;
  TVL_CHECK_INPUT(min_distance_px >= 0.0)
      << "min_distance_px: must not be negative, is " << min_distance_px;
}

std::vector<cv::Point> DetectFastCorners(const cv::Mat& grey, int border_px,
                                         const FastCornersOptions& options) {
  const std::vector<cv::KeyPoint> candidates =
      Candidates(grey, border_px, options.threshold_levels);
  std::vector<cv::Point> corners;
  Taken taken(grey.size(), options.min_distance_px);
  CellShares shares(grey.size(), options.cell_px, options.count);
  for (const bool keep_to_share : {true, false}) {
    for (const cv::KeyPoint& candidate : candidates) {
      if (static_cast<int>(corners.size()) == options.count) return corners;
      const cv::Point px(candidate.pt);
      if (taken.Contains(px) || (keep_to_share && !shares.HasRoom(px))) continue;
      taken.Add(px);
      shares.Add(px);
      corners.push_back(px);
    }
  }
  return corners;
}

}  // namespace tvl
