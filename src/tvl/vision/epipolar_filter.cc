#include "tvl/vision/epipolar_filter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "tvl/base/check.h"

namespace tvl {
namespace {

using Points = std::vector<cv::Point2f>;

Points ToReference(const std::vector<Eigen::Vector2d>& normalised, double focal_px) {
  Points px;
  px.reserve(normalised.size());
  for (const Eigen::Vector2d& n : normalised) {
    px.emplace_back(static_cast<float>(n.x() * focal_px), static_cast<float>(n.y() * focal_px));
  }
  return px;
}

double MedianFlow_px(const Points& previous, const Points& current) {
  std::vector<double> flow_px(previous.size());
  for (size_t i = 0; i < flow_px.size(); ++i) flow_px[i] = cv::norm(current[i] - previous[i]);
  const auto middle = flow_px.begin() + static_cast<std::ptrdiff_t>(flow_px.size() / 2);
  std::nth_element(flow_px.begin(), middle, flow_px.end());
  return *middle;
}

// The larger of the two distances point to epipolar line.
double Distance_px(const cv::Matx33d& F, const cv::Point2f& a, const cv::Point2f& b) {
  const cv::Vec3d pa(a.x, a.y, 1.0), pb(b.x, b.y, 1.0);
  const cv::Vec3d line_b = F * pa, line_a = F.t() * pb;
  const double e = std::abs(pb.dot(line_b));
  return e / std::max(1e-12,
                      std::min(std::hypot(line_a[0], line_a[1]), std::hypot(line_b[0], line_b[1])));
}

std::vector<uchar> Judge(const cv::Matx33d& F, const Points& a, const Points& b, double max_px) {
  std::vector<uchar> inlier(a.size());
  for (size_t i = 0; i < a.size(); ++i) inlier[i] = Distance_px(F, a[i], b[i]) <= max_px;
  return inlier;
}

size_t Count(const std::vector<uchar>& inlier) {
  return static_cast<size_t>(
      std::count_if(inlier.begin(), inlier.end(), [](uchar i) { return i; }));
}

// A model of seven noisy points turns good tracks away: fit to all inliers and judge again, as long
// as that gains some.
std::vector<uchar> Refine(const Points& a, const Points& b, std::vector<uchar> inlier,
                          double max_px) {
  for (int round = 0; round < 3; ++round) {
    Points in_a, in_b;
    for (size_t i = 0; i < a.size(); ++i) {
      if (!inlier[i]) continue;
      in_a.push_back(a[i]);
      in_b.push_back(b[i]);
    }
    if (in_a.size() < 8) return inlier;
    const cv::Mat F = cv::findFundamentalMat(in_a, in_b, cv::FM_8POINT);
    if (F.empty()) return inlier;
    std::vector<uchar> judged = Judge(cv::Matx33d(F), a, b, max_px);
    if (Count(judged) <= Count(inlier)) return inlier;
    inlier = std::move(judged);
  }
  return inlier;
}

}  // namespace

void EpipolarFilterOptions::Check() const {
  TVL_CHECK_INPUT(reference_focal_px > 0.0)
      << "reference_focal_px: must be positive, is " << reference_focal_px;
  TVL_CHECK_INPUT(max_distance_px > 0.0)
      << "max_distance_px: must be positive, is " << max_distance_px;
  TVL_CHECK_INPUT(confidence > 0.0 && confidence < 1.0)
      << "confidence: must lie between 0 and 1, is " << confidence;
  TVL_CHECK_INPUT(min_median_flow_px >= 0.0)
      << "min_median_flow_px: must not be negative, is " << min_median_flow_px;
  TVL_CHECK_INPUT(min_points >= 8) << "min_points: must be at least 8, is " << min_points;
}

std::vector<bool> EpipolarInliers(const std::vector<Eigen::Vector2d>& previous,
                                  const std::vector<Eigen::Vector2d>& current,
                                  const EpipolarFilterOptions& options) {
  TVL_CHECK(previous.size() == current.size()) << "points come in pairs";
  const std::vector<bool> all(previous.size(), true);
  if (previous.size() < static_cast<size_t>(options.min_points)) return all;
  const Points a = ToReference(previous, options.reference_focal_px);
  const Points b = ToReference(current, options.reference_focal_px);
  if (MedianFlow_px(a, b) < options.min_median_flow_px) return all;
  std::vector<uchar> inlier;
  const cv::Mat F = cv::findFundamentalMat(a, b, cv::FM_RANSAC, options.max_distance_px,
                                           options.confidence, inlier);
  if (F.rows != 3 || inlier.size() != a.size()) return all;
  inlier = Refine(a, b, std::move(inlier), options.max_distance_px);
  return {inlier.begin(), inlier.end()};
}

}  // namespace tvl
