// A map-like view from above.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace tvl {

// Black canvas onto which points are drawn by their x and y in metres.
class TopView {
 public:
  enum class Orientation {
    kForwardUp,  // x up, y left: a lidar's surroundings, as a driver sees them
    kEastRight,  // x right, y up: a map
  };

  // `top_left_m`: the coordinates (x, y) of the picture's top left corner.
  TopView(cv::Size size_px, double px_per_m, const Eigen::Vector2d& top_left_m,
          Orientation orientation);

  // Where a point lies, px; may be outside.
  Eigen::Vector2d Pixel(double x_m, double y_m) const;
  // A square of `side_px`; what is outside is cut.
  void Dot(double x_m, double y_m, const cv::Scalar& colour, int side_px = 1);
  // Circles around (0, 0) at each multiple of `step_m` in sight, with their distance.
  void RangeRings(double step_m);
  // A bar of `length_m` in the lower left corner.
  void ScaleBar(double length_m);

  cv::Mat& canvas() { return canvas_; }

 private:
  cv::Mat canvas_;
  double px_per_m_;
  Eigen::Vector2d top_left_m_;
  Orientation orientation_;
};

}  // namespace tvl
