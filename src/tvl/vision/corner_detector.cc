#include "tvl/vision/corner_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/vision/local_contrast.h"

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

// Strength of a corner at every pixel: the smaller eigenvalue of the 3x3 sum of gradient products
// (Shi-Tomasi), up to a constant factor; 0 along the image's edge. Same as OpenCV's
// cornerMinEigenVal, but from gradients that are there already, and in less time.
class StrengthMap {
 public:
  explicit StrengthMap(const cv::Mat& gradient)
      : columns_(static_cast<size_t>(gradient.cols)), map_(gradient.rows, gradient.cols, CV_32F) {
    map_.row(0).setTo(0.0f);
    map_.row(gradient.rows - 1).setTo(0.0f);
    Products above = RowProducts(gradient, 0), here = RowProducts(gradient, 1);
    for (int y = 1; y + 1 < gradient.rows; ++y) {
      const Products below = RowProducts(gradient, y + 1);
      FillRow(Sum(above, here, below), map_.ptr<float>(y));
      above = std::move(here);
      here = below;
    }
  }
  const cv::Mat& map() const { return map_; }

 private:
  struct Products {
    std::vector<float> xx, xy, yy;
  };

  Products RowProducts(const cv::Mat& gradient, int y) const {
    const int16_t* g = gradient.ptr<int16_t>(y);
    Products p{std::vector<float>(columns_), std::vector<float>(columns_),
               std::vector<float>(columns_)};
    for (size_t x = 0; x < columns_; ++x) {
      const float dx = g[2 * x], dy = g[2 * x + 1];
      p.xx[x] = dx * dx;
      p.xy[x] = dx * dy;
      p.yy[x] = dy * dy;
    }
    return p;
  }

  static std::vector<float> Sum(const std::vector<float>& a, const std::vector<float>& b,
                                const std::vector<float>& c) {
    std::vector<float> sum(a.size());
    for (size_t i = 0; i < sum.size(); ++i) sum[i] = a[i] + b[i] + c[i];
    return sum;
  }

  static Products Sum(const Products& a, const Products& b, const Products& c) {
    return {Sum(a.xx, b.xx, c.xx), Sum(a.xy, b.xy, c.xy), Sum(a.yy, b.yy, c.yy)};
  }

  void FillRow(const Products& p, float* strength) const {
    strength[0] = strength[columns_ - 1] = 0.0f;
    for (size_t x = 1; x + 1 < columns_; ++x) {
      const float xx = p.xx[x - 1] + p.xx[x] + p.xx[x + 1];
      const float xy = p.xy[x - 1] + p.xy[x] + p.xy[x + 1];
      const float yy = p.yy[x - 1] + p.yy[x] + p.yy[x + 1];
      const float half_difference = 0.5f * (xx - yy);
      strength[x] = 0.5f * (xx + yy) - std::sqrt(half_difference * half_difference + xy * xy);
    }
  }

  size_t columns_;
  cv::Mat map_;
};

// The strongest pixel of a block of the map.
Candidate StrongestIn(const cv::Mat& strength, const cv::Rect& block) {
  Candidate best{-1.0f, 0, 0};
  for (int y = block.y; y < block.y + block.height; ++y) {
    const float* row = strength.ptr<float>(y);
    for (int x = block.x; x < block.x + block.width; ++x) {
      if (row[x] > best.strength) best = {row[x], x, y};
    }
  }
  return best;
}

// No neighbour is stronger; it may lie in the block next door.
bool IsLocalMaximum(const cv::Mat& strength, const Candidate& c) {
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) {
      if (strength.at<float>(y, x) > c.strength) return false;
    }
  }
  return true;
}

// Local maxima in the mask above the quality threshold, one a block at most, strongest first.
std::vector<Candidate> FindCandidates(const cv::Mat& strength, const cv::Mat& mask, int block_px,
                                      double quality) {
  const cv::Rect inside(kBorder_px, kBorder_px, strength.cols - 2 * kBorder_px,
                        strength.rows - 2 * kBorder_px);
  std::vector<Candidate> candidates;
  for (int y = inside.y; y < inside.br().y; y += block_px) {
    for (int x = inside.x; x < inside.br().x; x += block_px) {
      const Candidate c = StrongestIn(strength, cv::Rect(x, y, block_px, block_px) & inside);
      if (!mask.empty() && mask.at<uint8_t>(c.y, c.x) == 0) continue;
      if (c.strength > 0.0f && IsLocalMaximum(strength, c)) candidates.push_back(c);
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    if (a.strength != b.strength) return a.strength > b.strength;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  const auto is_strong = [&](const Candidate& c) {
    return static_cast<double>(c.strength) >=
           quality * static_cast<double>(candidates.front().strength);
  };
  candidates.erase(std::partition_point(candidates.begin(), candidates.end(), is_strong),
                   candidates.end());
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
  TVL_CHECK_INPUT(min_contrast_sigmas >= 0.0)
      << "min_contrast_sigmas: must not be negative, is " << min_contrast_sigmas;
  TVL_CHECK_INPUT(min_contrast_levels >= 0.0)
      << "min_contrast_levels: must not be negative, is " << min_contrast_levels;
}

std::vector<cv::Point2f> DetectCorners(const cv::Mat& gradient, const cv::Mat& grey,
                                       const CornerSearch& search,
                                       const CornerDetectorOptions& options) {
  TVL_CHECK(grey.size() == gradient.size()) << "gradient and image belong together";
  std::vector<cv::Point2f> corners;
  TVL_CHECK(search.mask.empty() || search.mask.size() == grey.size()) << "a mask of the image";
  if (search.count <= 0 || std::min(gradient.cols, gradient.rows) <= 2 * kBorder_px) return corners;
  const cv::Mat strength = StrengthMap(gradient).map();
  const int block_px = std::max(3, static_cast<int>(0.4 * options.min_distance_px));
  const std::vector<Candidate> candidates =
      FindCandidates(strength, search.mask, block_px, options.quality);

  const double min_contrast =
      std::max(options.min_contrast_levels, options.min_contrast_sigmas * NoiseLevel(grey));

  Spacing spacing(gradient.size(), options.min_distance_px);
  Shares shares(gradient.size(), options.cell_px,
                search.count + static_cast<int>(search.occupied_px.size()));
  for (const cv::Point2f& px : search.occupied_px) {
    spacing.Add(px);
    shares.Add(px);
  }
  for (const bool keep_to_share : {true, false}) {
    for (const Candidate& candidate : candidates) {
      if (static_cast<int>(corners.size()) == search.count) return corners;
      const cv::Point2f px = SubPixel(strength, candidate);
      if ((keep_to_share && !shares.HasRoom(px)) || !spacing.IsFree(px)) continue;
      if (ContrastAround(grey, px) < min_contrast) continue;
      spacing.Add(px);
      shares.Add(px);
      corners.push_back(px);
    }
  }
  return corners;
}

}  // namespace tvl
