// Line plots: axes with round ticks, a grid, a legend.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace tvl {

struct PlotSeries {
  std::string name;                     // in the legend
  cv::Scalar colour;                    // BGR
  std::vector<Eigen::Vector2d> points;  // in the units of the axes, joined by lines
  bool marks_ends = false;              // a disc at the first point, a square at the last
  int width_px = 2;                     // of the line, before smoothing adds one
};

struct PlotOptions {
  std::string title, x_label, y_label;  // labels carry the units
  bool equal_scale = false;             // a metre is as long across as up: for maps
  bool y_from_zero = false;             // for errors
  int width_px = 1000, height_px = 720;
};

// Values on an axis.
struct AxisRange {
  double min = 0.0, max = 1.0;
};

// The multiples of 1, 2 or 5 times a power of ten inside the range, about `wanted` of them.
std::vector<double> RoundTicks(const AxisRange& range, int wanted);

// 8-bit BGR. Points that are not finite break the line. Series may be empty.
cv::Mat DrawPlot(const std::vector<PlotSeries>& series, const PlotOptions& options);

// Colours that can be told apart, also by the colour-blind; repeats after 6. Black first.
cv::Scalar SeriesColour(size_t index);

}  // namespace tvl
