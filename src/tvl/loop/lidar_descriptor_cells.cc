#include "tvl/loop/lidar_descriptor_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tvl {
namespace {

constexpr float kLayer_m = 0.5F;
// One point in so many may lie below the ground: reflections in car bodies and wet streets do, and
// one of them would turn the street for 10 m around it into something standing.
constexpr size_t kGhostShare = 10;

// Cells of a square image about the sensor.
struct SquareGrid {
  float range_m, per_m;
  int side;
  SquareGrid(double range, int cells)
      : range_m(static_cast<float>(range)),
        per_m(static_cast<float>(cells / (2.0 * range))),
        side(cells) {}
  int Coordinate(float v) const { return static_cast<int>((v + range_m) * per_m); }
  bool Holds(const Eigen::Vector3f& p) const {
    return std::abs(p.x()) < range_m && std::abs(p.y()) < range_m && std::isfinite(p.z());
  }
  size_t At(const Eigen::Vector3f& p) const {
    const int x = std::min(Coordinate(p.x()), side - 1), y = std::min(Coordinate(p.y()), side - 1);
    return static_cast<size_t>(y * side + x);
  }
};

template <typename Body>
void ForEachPoint(const KeyframeCloud& cloud, const Body& body) {
  for (const Eigen::Vector3f& p : cloud.edges.points) body(p);
  for (const Eigen::Vector3f& p : cloud.planes.points) body(p);
}

// One sweep of the lower envelope in reading order, or backwards.
void Sweep(std::vector<float>* height, int side, float rise, bool backwards) {
  const int step = backwards ? -1 : 1, first = backwards ? side - 1 : 0;
  const float diagonal = rise * std::sqrt(2.0F);
  const auto at = [&](int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < side && y < side;
    return inside ? (*height)[static_cast<size_t>(y * side + x)]
                  : std::numeric_limits<float>::infinity();
  };
  for (int j = 0, y = first; j < side; ++j, y += step) {
    for (int i = 0, x = first; i < side; ++i, x += step) {
      float& h = (*height)[static_cast<size_t>(y * side + x)];
      h = std::min({h, at(x - step, y) + rise, at(x, y - step) + rise,
                    at(x - step, y - step) + diagonal, at(x + step, y - step) + diagonal});
    }
  }
}

}  // namespace

float PlaceCell::weight() const { return std::sqrt(static_cast<float>(layers)); }

std::vector<float> GroundHeights(const KeyframeCloud& cloud, int side,
                                 const LidarDescriptorOptions& options) {
  const SquareGrid grid(options.range_m, side);
  std::vector<std::vector<float>> columns(static_cast<size_t>(side * side));
  ForEachPoint(cloud, [&](const Eigen::Vector3f& p) {
    if (grid.Holds(p)) columns[grid.At(p)].push_back(p.z());
  });
  std::vector<float> height(columns.size(), std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < columns.size(); ++i) {
    std::vector<float>& z = columns[i];
    if (z.empty()) continue;
    const auto low = z.begin() + static_cast<std::ptrdiff_t>(z.size() / kGhostShare);
    std::nth_element(z.begin(), low, z.end());
    height[i] = *low;
  }
  const float rise = static_cast<float>(options.ground_slope) / grid.per_m;
  Sweep(&height, side, rise, false);
  Sweep(&height, side, rise, true);
  return height;
}

std::vector<PlaceCell> StandingCells(const KeyframeCloud& cloud,
                                     const LidarDescriptorOptions& options) {
  const SquareGrid grid(options.range_m, options.grid());
  const SquareGrid ground(
      options.range_m,
      std::max(1, static_cast<int>(std::ceil(2.0 * options.range_m / options.ground_cell_m))));
  const std::vector<float> ground_m = GroundHeights(cloud, ground.side, options);
  const float low_m = static_cast<float>(options.min_height_m);
  const float high_m = static_cast<float>(options.max_height_m);
  const float range_sq = static_cast<float>(options.range_m * options.range_m);
  std::vector<uint32_t> layers(static_cast<size_t>(grid.side * grid.side), 0);
  ForEachPoint(cloud, [&](const Eigen::Vector3f& p) {
    if (!grid.Holds(p) || p.head<2>().squaredNorm() > range_sq) return;
    const float h = p.z() - ground_m[ground.At(p)];
    if (h < low_m || h > high_m) return;
    layers[grid.At(p)] |= 1U << std::min(31, static_cast<int>(h / kLayer_m));
  });
  std::vector<PlaceCell> cells;
  for (int y = 0; y < grid.side; ++y) {
    for (int x = 0; x < grid.side; ++x) {
      const uint32_t bits = layers[static_cast<size_t>(y * grid.side + x)];
      if (bits == 0) continue;
      cells.push_back({static_cast<int16_t>(x - grid.side / 2),
                       static_cast<int16_t>(y - grid.side / 2),
                       static_cast<uint8_t>(__builtin_popcount(bits))});
    }
  }
  return cells;
}

cv::Mat PlaceImage(const std::vector<PlaceCell>& cells, double yaw_rad, int side,
                   const LidarDescriptorOptions& options) {
  cv::Mat image(side, side, CV_32F, cv::Scalar(0));
  const float scale = static_cast<float>(side) / static_cast<float>(options.grid());
  const float c = static_cast<float>(std::cos(yaw_rad)), s = static_cast<float>(std::sin(yaw_rad));
  const float centre = 0.5F * static_cast<float>(side) - 0.5F;
  for (const PlaceCell& cell : cells) {
    const float x = (static_cast<float>(cell.x) + 0.5F) * scale;
    const float y = (static_cast<float>(cell.y) + 0.5F) * scale;
    const float u = c * x - s * y + centre, v = s * x + c * y + centre;
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
    const float fu = u - static_cast<float>(i), fv = v - static_cast<float>(j);
    for (int dv = 0; dv < 2; ++dv) {
      for (int du = 0; du < 2; ++du) {
        if (i + du < 0 || j + dv < 0 || i + du >= side || j + dv >= side) continue;
        image.at<float>(j + dv, i + du) +=
            cell.weight() * (du == 1 ? fu : 1.0F - fu) * (dv == 1 ? fv : 1.0F - fv);
      }
    }
  }
  return image;
}

}  // namespace tvl
