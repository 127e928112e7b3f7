#include "tvl/report/map_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tvl/geometry/point_index.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/report/canvas.h"
#include "tvl/report/top_view.h"

namespace tvl {
namespace {

constexpr double kMaxWidth_px = 1600.0, kMaxHeight_px = 1200.0, kMaxScale_px_per_m = 12.0;
constexpr double kShare = 0.002;  // points beyond these quantiles do not set the extent

struct Extent {
  double min = 0, max = 0;
  double length() const { return max - min; }
};

// Of one coordinate of the points, without the farthest few, and of all positions.
Extent ExtentOf(const MapCloud& map, const std::vector<Eigen::Vector3d>& p_world, int axis) {
  std::vector<float> values;
  values.reserve(map.points.size());
  for (const Eigen::Vector3f& p : map.points) values.push_back(p[axis]);
  Extent extent{1e9, -1e9};
  if (!values.empty()) {
    const auto quantile = [&](double share) {
      const auto nth = values.begin() +
                       static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), nth, values.end());
      return static_cast<double>(*nth);
    };
    extent = {quantile(kShare), quantile(1.0 - kShare)};
  }
  for (const Eigen::Vector3d& p : p_world) {
    extent = {std::min(extent.min, p[axis]), std::max(extent.max, p[axis])};
  }
  if (extent.min > extent.max) extent = {0.0, 0.0};
  return {extent.min - 3.0, extent.max + 3.0};
}

double NiceLength_m(double limit_m) {
  double nice = 1.0;
  for (const double length_m : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
    if (length_m <= limit_m) nice = length_m;
  }
  return nice;
}

// Height of the driven line where it passes closest, so that hills do not use up the colours.
class RoadHeights {
 public:
  explicit RoadHeights(const std::vector<Eigen::Vector3d>& p_world) {
    std::vector<Eigen::Vector3f> flat;
    for (const Eigen::Vector3d& p : p_world) {
      flat.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
      z_m_.push_back(p.z());
    }
    if (!flat.empty()) index_ = PointIndex(std::move(flat));
  }
  // The same for all points of a cell: close enough for a colour.
  double At(const Eigen::Vector3d& p_world) {
    if (z_m_.empty()) return 0.0;
    constexpr double kCell_m = 4.0;
    Cell& cell = cells_[VoxelKey::Of({p_world.x(), p_world.y(), 0.0}, kCell_m)];
    if (!cell.is_known) {
      Neighbour nearest{};
      const Eigen::Vector3f flat(static_cast<float>(p_world.x()), static_cast<float>(p_world.y()),
                                 0.0F);
      index_.Nearest(flat, 1, &nearest);
      cell = {true, z_m_[nearest.index]};
    }
    return cell.z_m;
  }

 private:
  struct Cell {
    bool is_known = false;
    double z_m = 0.0;
  };
  std::vector<double> z_m_;
  PointIndex index_;
  VoxelHash<Cell> cells_;
};

// Point indices from the lowest to the highest, so that high points are drawn over low ones.
std::vector<size_t> ByHeight(const MapCloud& map) {
  std::vector<size_t> order(map.points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return map.points[a].z() < map.points[b].z(); });
  return order;
}

}  // namespace

cv::Mat DrawMap(const MapCloud& map, const std::vector<Eigen::Vector3d>& p_world) {
  const Extent x = ExtentOf(map, p_world, 0), y = ExtentOf(map, p_world, 1);
  const double scale =
      std::min({kMaxWidth_px / x.length(), kMaxHeight_px / y.length(), kMaxScale_px_per_m});
  const cv::Size size(std::max(320, static_cast<int>(x.length() * scale)),
                      std::max(200, static_cast<int>(y.length() * scale)));
  TopView view(size, scale, {x.min, y.max}, TopView::Orientation::kEastRight);

  RoadHeights road(p_world);
  constexpr double kBelow_m = 2.0, kSpan_m = 6.0;  // the road lies 1.7 m below the lidar
  for (const size_t i : ByHeight(map)) {
    const Eigen::Vector3d p = map.points[i].cast<double>();
    view.Dot(p.x(), p.y(), NearToFar(1.0 - (p.z() - road.At(p) + kBelow_m) / kSpan_m));
  }
  const cv::Scalar white = cv::Scalar::all(255);
  for (size_t i = 1; i < p_world.size(); ++i) {
    cv::line(view.canvas(), ShiftedPoint(view.Pixel(p_world[i - 1].x(), p_world[i - 1].y())),
             ShiftedPoint(view.Pixel(p_world[i].x(), p_world[i].y())), white, 2, cv::LINE_AA,
             kShift);
  }
  view.ScaleBar(NiceLength_m(0.3 * static_cast<double>(size.width) / scale));
  return WithLegend(view.canvas(), std::to_string(map.points.size()) + " points",
                    {{NearToFar(1.0), "2 m below the lidar's path"},
                     {NearToFar(0.5), "1 m above"},
                     {NearToFar(0.0), "4 m above"},
                     {white, "driven line"}});
}

}  // namespace tvl
