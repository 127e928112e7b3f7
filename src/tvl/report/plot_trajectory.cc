#include "tvl/report/plot_trajectory.h"

#include "tvl/report/plot.h"

namespace tvl {
namespace {

// The truth is wider, so that it shows under an estimate that lies on it.
int LineWidth(size_t index) { return index == 0 ? 3 : 1; }

}  // namespace

cv::Mat DrawTopView(const std::string& title, const std::vector<NamedPath>& paths) {
  PlotOptions options;
  options.title = title;
  options.x_label = "x, right [m]";
  options.y_label = "z, forward [m]";
  options.equal_scale = true;
  options.height_px = 900;
  std::vector<PlotSeries> series;
  for (const NamedPath& path : paths) {
    PlotSeries s{path.name, SeriesColour(series.size()), {}, true, LineWidth(series.size())};
    for (const Rigid3d& pose : path.poses) s.points.emplace_back(pose.t().x(), pose.t().z());
    series.push_back(std::move(s));
  }
  return DrawPlot(series, options);
}

cv::Mat DrawHeights(const std::string& title, const std::vector<NamedPath>& paths) {
  PlotOptions options;
  options.title = title;
  options.x_label = "path [m]";
  options.y_label = "height [m]";
  options.height_px = 480;
  std::vector<PlotSeries> series;
  for (const NamedPath& path : paths) {
    PlotSeries s{path.name, SeriesColour(series.size()), {}, false, LineWidth(series.size())};
    double length_m = 0.0;
    for (size_t i = 0; i < path.poses.size(); ++i) {
      if (i > 0) length_m += (path.poses[i].t() - path.poses[i - 1].t()).norm();
      s.points.emplace_back(length_m, -path.poses[i].t().y());
    }
    series.push_back(std::move(s));
  }
  return DrawPlot(series, options);
}

cv::Mat DrawErrors(const std::string& title, const std::vector<NamedErrors>& errors) {
  PlotOptions options;
  options.title = title;
  options.x_label = "frame";
  options.y_label = "position error [m]";
  options.y_from_zero = true;
  options.height_px = 480;
  std::vector<PlotSeries> series;
  for (const NamedErrors& named : errors) {
    PlotSeries s{named.name, SeriesColour(series.size() + 1), {}, false};
    for (size_t i = 0; i < named.errors_m.size(); ++i) {
      s.points.emplace_back(static_cast<double>(i), named.errors_m[i]);
    }
    series.push_back(std::move(s));
  }
  return DrawPlot(series, options);
}

}  // namespace tvl
