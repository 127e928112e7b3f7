#include "tvl/report/top_view.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tvl/base/check.h"
#include "tvl/report/canvas.h"

namespace tvl {
namespace {

std::string Metres(double length_m) {
  return std::to_string(static_cast<int>(std::lround(length_m))) + " m";
}

}  // namespace

TopView::TopView(cv::Size size_px, double px_per_m, const Eigen::Vector2d& top_left_m,
                 Orientation orientation)
    : canvas_(size_px, CV_8UC3, cv::Scalar::all(0)),
      px_per_m_(px_per_m),
      top_left_m_(top_left_m),
      orientation_(orientation) {
  TVL_CHECK(px_per_m > 0.0) << "a view has a scale";
}

Eigen::Vector2d TopView::Pixel(double x_m, double y_m) const {
  const double dx = x_m - top_left_m_.x(), dy = y_m - top_left_m_.y();
  if (orientation_ == Orientation::kForwardUp) return {-dy * px_per_m_, -dx * px_per_m_};
  return {dx * px_per_m_, -dy * px_per_m_};
}

void TopView::Dot(double x_m, double y_m, const cv::Scalar& colour, int side_px) {
  const Eigen::Vector2d px = Pixel(x_m, y_m);
  if (!(px.cwiseAbs().maxCoeff() < 1e6)) return;
  const cv::Rect dot(static_cast<int>(std::floor(px.x())) - side_px / 2,
                     static_cast<int>(std::floor(px.y())) - side_px / 2, side_px, side_px);
  const cv::Rect inside = dot & cv::Rect({0, 0}, canvas_.size());
  if (!inside.empty()) canvas_(inside).setTo(colour);
}

void TopView::RangeRings(double step_m) {
  const cv::Scalar grey = cv::Scalar::all(70);
  const cv::Point centre = ShiftedPoint(Pixel(0.0, 0.0));
  const double reach_m = std::hypot(canvas_.cols, canvas_.rows) / px_per_m_;
  for (double r_m = step_m; r_m < reach_m; r_m += step_m) {
    cv::circle(canvas_, centre, static_cast<int>(r_m * px_per_m_ * (1 << kShift)), grey, 1,
               cv::LINE_AA, kShift);
    const Eigen::Vector2d label = Pixel(r_m, 0.0);
    cv::putText(canvas_, Metres(r_m),
                {static_cast<int>(label.x()) + 3, static_cast<int>(label.y()) + 12},
                cv::FONT_HERSHEY_SIMPLEX, 0.38, cv::Scalar::all(140), 1, cv::LINE_AA);
  }
}

void TopView::ScaleBar(double length_m) {
  const int y = canvas_.rows - 14, x = 14;
  const int end = x + static_cast<int>(std::lround(length_m * px_per_m_));
  const cv::Scalar white = cv::Scalar::all(255);
  cv::line(canvas_, {x, y}, {end, y}, white, 2);
  cv::line(canvas_, {x, y - 4}, {x, y + 4}, white, 2);
  cv::line(canvas_, {end, y - 4}, {end, y + 4}, white, 2);
  cv::putText(canvas_, Metres(length_m), {end + 8, y + 5}, cv::FONT_HERSHEY_SIMPLEX, 0.45, white, 1,
              cv::LINE_AA);
}

}  // namespace tvl
