#include "tvl/vision/corner_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr int kBorder_px = 3;  // corners nearer to the image's edge are not looked at

struct Candidate {
  float strength;
  int x, y;
};

// Keeps points apart: a grid of cells as wide as the distance, each with the points inside.
class Spacing {
 public:
  Spacing(cv::Size image, double distance_px)
      : distance_px_(distance_px),
        columns_(static_cast<int>(image.width / distance_px) + 1),
        rows_(static_cast<int>(image.height / distance_px) + 1),
        cells_(static_cast<size_t>(columns_ * rows_)) {}

  void Add(const cv::Point2f& px) { cells_[Cell(Column(px), Row(px))].push_back(px); }

  bool IsFree(const cv::Point2f& px) const {
    const int column = Column(px), row = Row(px);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        for (const cv::Point2f& other : cells_[Cell(c, r)]) {
          if (cv::norm(px - other) < distance_px_) return false;
        }
      }
    }
    return true;
  }

 private:
  int Column(const cv::Point2f& px) const {
    return std::clamp(static_cast<int>(px.x / distance_px_), 0, columns_ - 1);
  }
  int Row(const cv::Point2f& px) const {
    return std::clamp(static_cast<int>(px.y / distance_px_), 0, rows_ - 1);
  }
  size_t Cell(int column, int row) const { return static_cast<size_t>(row * columns_ + column); }

  double distance_px_;
  int columns_, rows_;
  std::vector<std::vector<cv::Point2f>> cells_;
};

// How many features each cell of a coarse grid holds, and may hold.
class Shares {
 public:
  Shares(cv::Size image, double cell_px, int features)
      : columns_(std::max(1, static_cast<int>(std::lround(image.width / cell_px)))),
        rows_(std::max(1, static_cast<int>(std::lround(image.height / cell_px)))),
        image_(image),
        held_(static_cast<size_t>(columns_ * rows_), 0),
        share_((features + columns_ * rows_ - 1) / (columns_ * rows_)) {}

  void Add(const cv::Point2f& px) { ++held_[Cell(px)]; }
  bool HasRoom(const cv::Point2f& px) const { return held_[Cell(px)] < share_; }

 private:
  size_t Cell(const cv::Point2f& px) const {
    const int c = std::clamp(static_cast<int>(px.x) * columns_ / image_.width, 0, columns_ - 1);
    const int r = std::clamp(static_cast<int>(px.y) * rows_ / image_.height, 0, rows_ - 1);
    return static_cast<size_t>(r * columns_ + c);
  }

  int columns_, rows_;
  cv::Size image_;
  std::vector<int> held_;
  int share_;
};

// Local maxima of the smaller eigenvalue above the quality threshold, strongest first.
std::vector<Candidate> FindCandidates(const cv::Mat& strength, double quality) {
  const cv::Rect inside(kBorder_px, kBorder_px, strength.cols - 2 * kBorder_px,
                        strength.rows - 2 * kBorder_px);
  double strongest = 0.0;
  cv::minMaxLoc(strength(inside), nullptr, &strongest);
  const float threshold = static_cast<float>(quality * strongest);
  std::vector<Candidate> candidates;
  if (!(threshold > 0.0f)) return candidates;
  for (int y = inside.y; y < inside.y + inside.height; ++y) {
    const float* above = strength.ptr<float>(y - 1);
    const float* row = strength.ptr<float>(y);
    const float* below = strength.ptr<float>(y + 1);
    for (int x = inside.x; x < inside.x + inside.width; ++x) {
      const float s = row[x];
      // Strict on one side only: a plateau yields one corner.
      if (s < threshold || s <= row[x - 1] || s < row[x + 1]) continue;
      if (s <= above[x - 1] || s <= above[x] || s <= above[x + 1]) continue;
      if (s < below[x - 1] || s < below[x] || s < below[x + 1]) continue;
      candidates.push_back({s, x, y});
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    if (a.strength != b.strength) return a.strength > b.strength;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  return candidates;
}

// Vertex of the parabola through three neighbouring strengths, relative to the middle one.
float Vertex(float before, float middle, float after) {
  const float curvature = before - 2.0f * middle + after;
  if (!(curvature < 0.0f)) return 0.0f;
  return std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f);
}

cv::Point2f SubPixel(const cv::Mat& strength, const Candidate& c) {
  const float* row = strength.ptr<float>(c.y);
  const float dx = Vertex(row[c.x - 1], row[c.x], row[c.x + 1]);
  const float dy =
      Vertex(strength.at<float>(c.y - 1, c.x), row[c.x], strength.at<float>(c.y + 1, c.x));
  return {static_cast<float>(c.x) + dx, static_cast<float>(c.y) + dy};
}

}  // namespace

void CornerDetectorOptions::Check() const {
  TVL_CHECK_INPUT(min_distance_px >= 1.0)
      << "min_distance_px: must be at least 1, is " << min_distance_px;
  TVL_CHECK_INPUT(quality > 0.0 && quality < 1.0)
      << "quality: must lie between 0 and 1, is " << quality;
  TVL_CHECK_INPUT(cell_px >= min_distance_px)
      << "cell_px: must be at least min_distance_px, is " << cell_px;
}

std::vector<cv::Point2f> DetectCorners(const cv::Mat& grey,
                                       const std::vector<cv::Point2f>& occupied_px, int count,
                                       const CornerDetectorOptions& options) {
  std::vector<cv::Point2f> corners;
  if (count <= 0 || std::min(grey.cols, grey.rows) <= 2 * kBorder_px) return corners;
  cv::Mat strength;
  cv::cornerMinEigenVal(grey, strength, 3, 3);
  const std::vector<Candidate> candidates = FindCandidates(strength, options.quality);

  Spacing spacing(grey.size(), options.min_distance_px);
  Shares shares(grey.size(), options.cell_px, count + static_cast<int>(occupied_px.size()));
  for (const cv::Point2f& px : occupied_px) {
    spacing.Add(px);
    shares.Add(px);
  }
  for (const bool keep_to_share : {true, false}) {
    for (const Candidate& candidate : candidates) {
      if (static_cast<int>(corners.size()) == count) return corners;
      const cv::Point2f px = SubPixel(strength, candidate);
      if ((keep_to_share && !shares.HasRoom(px)) || !spacing.IsFree(px)) continue;
      spacing.Add(px);
      shares.Add(px);
      corners.push_back(px);
    }
  }
  return corners;
}

}  // namespace tvl
