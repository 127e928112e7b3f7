#include "tvl/vision/optical_flow.h"

#include <opencv2/video/tracking.hpp>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {
namespace {

struct LkResult {
  std::vector<cv::Point2f> px;
  std::vector<uchar> found;
};

// LK from `from` to `to`, starting at `guess_px` (as long as points_px).
LkResult RunLk(const ImagePyramid& from, const ImagePyramid& to,
               const std::vector<cv::Point2f>& points_px, std::vector<cv::Point2f> guess_px,
               int max_level, const OpticalFlowOptions& options) {
  LkResult result{std::move(guess_px), {}};
  if (points_px.empty()) return result;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS,
                              options.max_iterations, options.min_step_px);
  cv::calcOpticalFlowPyrLK(from.levels(), to.levels(), points_px, result.px, result.found,
                           cv::noArray(), cv::Size(options.window_px, options.window_px), max_level,
                           stop, cv::OPTFLOW_USE_INITIAL_FLOW);
  return result;
}

bool IsInside(const cv::Point2f& px, const cv::Size& size) {
  return px.x >= 1.0f && px.y >= 1.0f && px.x <= static_cast<float>(size.width - 2) &&
         px.y <= static_cast<float>(size.height - 2);
}

// Forward from the guesses, then back. The way back starts where it should end: it needs no
// pyramid.
std::vector<FlowPoint> ThereAndBack(const ImagePyramid& previous, const ImagePyramid& current,
                                    const std::vector<cv::Point2f>& points_px,
                                    const std::vector<cv::Point2f>& guess_px, int max_level,
                                    const OpticalFlowOptions& options) {
  const LkResult there = RunLk(previous, current, points_px, guess_px, max_level, options);
  const LkResult back = RunLk(current, previous, there.px, points_px, 0, options);
  std::vector<FlowPoint> result(points_px.size());
  for (size_t i = 0; i < result.size(); ++i) {
    result[i].px = there.px[i];
    if (!there.found[i] || !IsInside(there.px[i], current.size())) continue;
    const double error_px = back.found[i] ? cv::norm(back.px[i] - points_px[i]) : 1e9;
    result[i].status = error_px <= options.max_backward_error_px ? FlowStatus::kTracked
                                                                 : FlowStatus::kBackwardMismatch;
  }
  return result;
}

// Runs the points named by `index` and writes their results into `result`.
void TrackSubset(const ImagePyramid& previous, const ImagePyramid& current,
                 const std::vector<cv::Point2f>& points_px,
                 const std::vector<cv::Point2f>& guess_px, const std::vector<size_t>& index,
                 int max_level, const OpticalFlowOptions& options, std::vector<FlowPoint>& result) {
  std::vector<cv::Point2f> from, guess;
  for (const size_t i : index) {
    from.push_back(points_px[i]);
    guess.push_back(guess_px[i]);
  }
  const std::vector<FlowPoint> tracked =
      ThereAndBack(previous, current, from, guess, max_level, options);
  for (size_t k = 0; k < index.size(); ++k) result[index[k]] = tracked[k];
}

}  // namespace

void OpticalFlowOptions::Check() const {
  TVL_CHECK_INPUT(window_px >= 5 && window_px % 2 == 1)
      << "window_px: must be odd and at least 5, is " << window_px;
  TVL_CHECK_INPUT(max_level >= 0 && max_level <= 8)
      << "max_level: must lie in 0..8, is " << max_level;
  TVL_CHECK_INPUT(seeded_level >= 0 && seeded_level <= max_level)
      << "seeded_level: must lie in 0..max_level, is " << seeded_level;
  TVL_CHECK_INPUT(max_iterations >= 1)
      << "max_iterations: must be at least 1, is " << max_iterations;
  TVL_CHECK_INPUT(min_step_px > 0.0) << "min_step_px: must be positive, is " << min_step_px;
  TVL_CHECK_INPUT(max_backward_error_px > 0.0)
      << "max_backward_error_px: must be positive, is " << max_backward_error_px;
}

ImagePyramid::ImagePyramid(cv::Mat grey, const OpticalFlowOptions& options)
    : grey_(std::move(grey)), window_px_(options.window_px), max_level_(options.max_level) {
  TVL_CHECK(grey_.type() == CV_8UC1) << "a pyramid is made of an 8-bit grey image";
  cv::buildOpticalFlowPyramid(grey_, levels_, cv::Size(window_px_, window_px_), max_level_, true,
                              cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
}

ImagePyramid ImagePyramid::Part(const cv::Rect& area, int max_level) const {
  TVL_CHECK(max_level <= max_level_ &&
            ((area.x | area.y | area.width | area.height) & ((1 << max_level) - 1)) == 0)
      << "the corners of a part fall on pixels of every level";
  ImagePyramid part;
  part.grey_ = grey_(area);
  part.window_px_ = window_px_;
  part.max_level_ = max_level;
  for (size_t k = 0; k < levels_.size() && static_cast<int>(k / 2) <= max_level; ++k) {
    const int level = static_cast<int>(k / 2);  // grey and gradient take turns
    part.levels_.push_back(levels_[k](
        cv::Rect(area.x >> level, area.y >> level, area.width >> level, area.height >> level)));
  }
  return part;
}

ImagePyramid::ImagePyramid(const ImagePyramid& other) { *this = other; }

ImagePyramid& ImagePyramid::operator=(const ImagePyramid& other) {
  if (this == &other) return *this;
  if (other.empty()) return *this = ImagePyramid();
  OpticalFlowOptions options;
  options.window_px = other.window_px_;
  options.max_level = other.max_level_;
  return *this = ImagePyramid(other.grey_.clone(), options);
}

std::vector<FlowPoint> TrackPoints(const ImagePyramid& previous, const ImagePyramid& current,
                                   const std::vector<cv::Point2f>& points_px,
                                   const std::vector<FlowSeed>& seeds,
                                   const OpticalFlowOptions& options) {
  TVL_CHECK(seeds.empty() || seeds.size() == points_px.size()) << "one seed a point, or none";
  TVL_CHECK(previous.size() == current.size()) << "images of one size";
  std::vector<FlowPoint> result(points_px.size());
  std::vector<cv::Point2f> guess_px = points_px;
  std::vector<size_t> predicted, rest;
  for (size_t i = 0; i < points_px.size(); ++i) {
    if (!seeds.empty()) guess_px[i] = seeds[i].px;
    (!seeds.empty() && seeds[i].predicted ? predicted : rest).push_back(i);
  }
  TrackSubset(previous, current, points_px, guess_px, predicted, options.seeded_level, options,
              result);
  for (const size_t i : predicted) {
    if (result[i].status == FlowStatus::kTracked) continue;
    guess_px[i] = points_px[i];
    rest.push_back(i);
  }
  TrackSubset(previous, current, points_px, guess_px, rest, options.max_level, options, result);
  return result;
}

}  // namespace tvl
