#include "tvl/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace tvl {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kTextScale = 0.5, kTitleScale = 0.65;
constexpr int kLeft_px = 90, kRight_px = 30, kTop_px = 84, kBottom_px = 64;
constexpr int kXTicks_px = 90, kYTicks_px = 45;  // about this far apart
constexpr int kShift = 3;                        // fractional bits of drawn coordinates
const cv::Scalar kInk = cv::Scalar::all(40), kGrid = cv::Scalar::all(225);

// Where the axes lie on the picture and what they show.
struct Frame {
  cv::Rect box;
  AxisRange x, y;

  cv::Point2d Pixel(double x_value, double y_value) const {
    return {box.x + (x_value - x.min) / (x.max - x.min) * box.width,
            box.y + box.height - (y_value - y.min) / (y.max - y.min) * box.height};
  }
};

cv::Point Shifted(const cv::Point2d& px) {
  const double scale = 1 << kShift;
  return {cvRound(px.x * scale), cvRound(px.y * scale)};
}

cv::Size TextSize(const std::string& text, double scale) {
  return cv::getTextSize(text, kFont, scale, 1, nullptr);
}

void Write(cv::Mat& picture, const std::string& text, cv::Point at, double scale = kTextScale) {
  cv::putText(picture, text, at, kFont, scale, kInk, 1, cv::LINE_AA);
}

// Bottom to top, centred on `centre`.
void WriteUpwards(cv::Mat& picture, const std::string& text, cv::Point centre) {
  const cv::Size size = TextSize(text, kTextScale);
  cv::Mat label(size.height + 10, size.width + 4, CV_8UC3, cv::Scalar::all(255));
  Write(label, text, {2, size.height + 2});
  cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Rect wanted(centre.x - label.cols / 2, centre.y - label.rows / 2, label.cols,
                        label.rows);
  const cv::Rect place = wanted & cv::Rect(0, 0, picture.cols, picture.rows);
  label(place - wanted.tl()).copyTo(picture(place));
}

std::string TickText(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.*f", decimals, value == 0.0 ? 0.0 : value);
  return buffer;
}

// Range of one coordinate over all finite points, with a margin; 0..1 without any.
AxisRange DataRange(const std::vector<PlotSeries>& series, int axis) {
  double min = HUGE_VAL, max = -HUGE_VAL;
  for (const PlotSeries& s : series) {
    for (const Eigen::Vector2d& p : s.points) {
      if (!p.allFinite()) continue;
      min = std::min(min, p[axis]);
      max = std::max(max, p[axis]);
    }
  }
  if (min > max) return {};
  const double margin = std::max(0.04 * (max - min), 1e-9 + 1e-6 * std::abs(max));
  return {min - margin, max + margin};
}

AxisRange Widened(const AxisRange& range, double length) {
  const double centre = 0.5 * (range.min + range.max);
  return {centre - 0.5 * length, centre + 0.5 * length};
}

Frame LayOut(const std::vector<PlotSeries>& series, const PlotOptions& options) {
  Frame frame;
  frame.box = cv::Rect(kLeft_px, kTop_px, options.width_px - kLeft_px - kRight_px,
                       options.height_px - kTop_px - kBottom_px);
  frame.x = DataRange(series, 0);
  frame.y = DataRange(series, 1);
  if (options.y_from_zero) frame.y.min = 0.0;
  if (options.equal_scale) {
    const double units_per_px = std::max((frame.x.max - frame.x.min) / frame.box.width,
                                         (frame.y.max - frame.y.min) / frame.box.height);
    frame.x = Widened(frame.x, units_per_px * frame.box.width);
    frame.y = Widened(frame.y, units_per_px * frame.box.height);
  }
  return frame;
}

void DrawXTicks(cv::Mat& picture, const Frame& frame) {
  const std::vector<double> ticks = RoundTicks(frame.x, std::max(3, frame.box.width / kXTicks_px));
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  const int bottom = frame.box.y + frame.box.height;
  for (const double tick : ticks) {
    const int x = cvRound(frame.Pixel(tick, frame.y.min).x);
    cv::line(picture, {x, frame.box.y}, {x, bottom}, kGrid);
    cv::line(picture, {x, bottom}, {x, bottom + 5}, kInk);
    const std::string text = TickText(tick, step);
    Write(picture, text, {x - TextSize(text, kTextScale).width / 2, bottom + 22});
  }
}

void DrawYTicks(cv::Mat& picture, const Frame& frame, int spacing_px) {
  const std::vector<double> ticks = RoundTicks(frame.y, std::max(3, frame.box.height / spacing_px));
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  for (const double tick : ticks) {
    const int y = cvRound(frame.Pixel(frame.x.min, tick).y);
    cv::line(picture, {frame.box.x, y}, {frame.box.x + frame.box.width, y}, kGrid);
    cv::line(picture, {frame.box.x - 5, y}, {frame.box.x, y}, kInk);
    const std::string text = TickText(tick, step);
    const cv::Size size = TextSize(text, kTextScale);
    Write(picture, text, {frame.box.x - 9 - size.width, y + size.height / 2});
  }
}

void DrawLabels(cv::Mat& picture, const Frame& frame, const PlotOptions& options) {
  const cv::Size title = TextSize(options.title, kTitleScale);
  Write(picture, options.title, {(picture.cols - title.width) / 2, 28}, kTitleScale);
  const cv::Size x_label = TextSize(options.x_label, kTextScale);
  const int centre_x = frame.box.x + frame.box.width / 2;
  Write(picture, options.x_label, {centre_x - x_label.width / 2, picture.rows - 16});
  WriteUpwards(picture, options.y_label, {18, frame.box.y + frame.box.height / 2});
}

// One row between title and axes.
void DrawLegend(cv::Mat& picture, const std::vector<PlotSeries>& series) {
  constexpr int kLine_px = 34, kGap_px = 8, kBetween_px = 28;
  int width = -kBetween_px;
  for (const PlotSeries& s : series) {
    width += kLine_px + kGap_px + TextSize(s.name, kTextScale).width + kBetween_px;
  }
  int x = std::max(kGap_px, (picture.cols - width) / 2);
  for (const PlotSeries& s : series) {
    cv::line(picture, {x, 56}, {x + kLine_px, 56}, s.colour, s.width_px, cv::LINE_AA);
    x += kLine_px + kGap_px;
    Write(picture, s.name, {x, 61});
    x += TextSize(s.name, kTextScale).width + kBetween_px;
  }
}

void DrawEnds(cv::Mat& picture, const Frame& frame, const PlotSeries& series) {
  const auto& [first, last] = std::make_pair(series.points.front(), series.points.back());
  const cv::Point begin = frame.Pixel(first.x(), first.y()), end = frame.Pixel(last.x(), last.y());
  cv::circle(picture, begin, 5, series.colour, cv::FILLED, cv::LINE_AA);
  cv::rectangle(picture, end - cv::Point(5, 5), end + cv::Point(5, 5), series.colour, 2);
}

void DrawSeries(cv::Mat& picture, const Frame& frame, const PlotSeries& series) {
  for (size_t i = 1; i < series.points.size(); ++i) {
    const Eigen::Vector2d &a = series.points[i - 1], &b = series.points[i];
    if (!a.allFinite() || !b.allFinite()) continue;
    cv::line(picture, Shifted(frame.Pixel(a.x(), a.y())), Shifted(frame.Pixel(b.x(), b.y())),
             series.colour, series.width_px, cv::LINE_AA, kShift);
  }
  if (series.marks_ends && !series.points.empty()) DrawEnds(picture, frame, series);
}

}  // namespace

std::vector<double> RoundTicks(const AxisRange& range, int wanted) {
  const double rough = (range.max - range.min) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough * (1.0 - 1e-9)) step = factor * power;
  }
  std::vector<double> ticks;
  const auto first = static_cast<int64_t>(std::ceil(range.min / step - 1e-9));
  const auto last = static_cast<int64_t>(std::floor(range.max / step + 1e-9));
  for (int64_t i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

cv::Mat DrawPlot(const std::vector<PlotSeries>& series, const PlotOptions& options) {
  cv::Mat picture(options.height_px, options.width_px, CV_8UC3, cv::Scalar::all(255));
  const Frame frame = LayOut(series, options);
  DrawXTicks(picture, frame);
  // On a map the grid is of squares.
  DrawYTicks(picture, frame, options.equal_scale ? kXTicks_px : kYTicks_px);
  DrawLabels(picture, frame, options);
  DrawLegend(picture, series);
  for (const PlotSeries& s : series) DrawSeries(picture, frame, s);
  cv::rectangle(picture, frame.box, kInk);
  return picture;
}

cv::Scalar SeriesColour(size_t index) {
  const std::array<cv::Scalar, 6> colours = {cv::Scalar(40, 40, 40),    cv::Scalar(178, 114, 0),
                                             cv::Scalar(0, 94, 213),    cv::Scalar(115, 158, 0),
                                             cv::Scalar(167, 121, 204), cv::Scalar(0, 159, 230)};
  return colours[index % colours.size()];
}

}  // namespace tvl
