#include "tvl/loop/bev_alignment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/geometry/voxel_hash.h"

namespace tvl {
namespace {

constexpr size_t kNoColumn = std::numeric_limits<size_t>::max();
constexpr uint8_t kHit = 2, kBeside = 1;  // weights of a target's cell

int CellOf(double x_m, double cell_m) { return static_cast<int>(std::floor(x_m / cell_m)); }

// A square grid of weights round the origin.
class TargetGrid {
 public:
  TargetGrid(const std::vector<Eigen::Vector2f>& points, int half, double cell_m)
      : half_(half),
        width_(2 * half + 1),
        weights_(static_cast<size_t>(width_) * static_cast<size_t>(width_), 0) {
    for (const Eigen::Vector2f& p : points) {
      const int x = CellOf(p.x(), cell_m), y = CellOf(p.y(), cell_m);
      if (std::abs(x) < half && std::abs(y) < half) Draw(x, y);
    }
  }
  // Cells (x, y), (x + 1, y), ...; the caller stays inside.
  const uint8_t* Row(int x, int y) const { return &weights_[Index(x, y)]; }
  bool Contains(int x, int y) const { return std::abs(x) <= half_ && std::abs(y) <= half_; }

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y + half_) * static_cast<size_t>(width_) +
           static_cast<size_t>(x + half_);
  }
  void Draw(int x, int y) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        uint8_t& weight = weights_[Index(x + dx, y + dy)];
        weight = std::max(weight, dx == 0 && dy == 0 ? kHit : kBeside);
      }
    }
  }
  int half_, width_;
  std::vector<uint8_t> weights_;
};

// One point a cell.
std::vector<Eigen::Vector2f> ThinToCells(const std::vector<Eigen::Vector2f>& points,
                                         const BevAlignmentOptions& options) {
  VoxelHash<char> seen;
  std::vector<Eigen::Vector2f> kept;
  for (const Eigen::Vector2f& p : points) {
    if (p.norm() > options.range_m) continue;
    char& taken = seen[{CellOf(p.x(), options.cell_m), CellOf(p.y(), options.cell_m), 0}];
    if (taken == 0) kept.push_back(p);
    taken = 1;
  }
  return kept;
}

// The window of translations, in cells.
struct Window {
  int half = 0, side = 0;  // side = 2 half + 1
  int centre_x = 0, centre_y = 0;
};

// scores[dy * side + dx]: weights met by the source, turned and shifted by each (dx, dy).
std::vector<uint16_t> ScoreShifts(const TargetGrid& target,
                                  const std::vector<Eigen::Vector2f>& source, double yaw_rad,
                                  const Window& window, double cell_m) {
  const auto side = static_cast<size_t>(window.side);
  std::vector<uint16_t> scores(side * side, 0);
  const Eigen::Matrix2f R = Eigen::Rotation2D<float>(static_cast<float>(yaw_rad)).matrix();
  for (const Eigen::Vector2f& p : source) {
    const Eigen::Vector2f turned = R * p;
    const int x = CellOf(turned.x(), cell_m) + window.centre_x - window.half;
    const int y = CellOf(turned.y(), cell_m) + window.centre_y - window.half;
    if (!target.Contains(x, y) || !target.Contains(x + window.side, y + window.side)) continue;
    for (int dy = 0; dy < window.side; ++dy) {
      const uint8_t* from = target.Row(x, y + dy);
      uint16_t* to = &scores[static_cast<size_t>(dy) * side];
      for (size_t dx = 0; dx < side; ++dx) to[dx] = static_cast<uint16_t>(to[dx] + from[dx]);
    }
  }
  return scores;
}

bool IsShoulder(const BevPeak& peak, const std::vector<BevPeak>& better,
                const BevAlignmentOptions& options) {
  return std::any_of(better.begin(), better.end(), [&](const BevPeak& other) {
    return std::hypot(peak.x_m - other.x_m, peak.y_m - other.y_m) < options.peak_distance_m &&
           std::abs(std::remainder(peak.yaw_rad - other.yaw_rad, 2.0 * kPi)) < options.peak_yaw_rad;
  });
}

struct Scores {
  std::vector<double> yaw_rad;
  std::vector<std::vector<uint16_t>> of_yaw;
};

// The best alignment that is no shoulder of those found; its score is 0 if there is none.
BevPeak NextPeak(const Scores& scores, const Window& window, size_t source_cells,
                 const std::vector<BevPeak>& found, const BevAlignmentOptions& options) {
  BevPeak best;
  uint16_t best_score = 0;
  for (size_t k = 0; k < scores.of_yaw.size(); ++k) {
    for (size_t i = 0; i < scores.of_yaw[k].size(); ++i) {
      if (scores.of_yaw[k][i] <= best_score) continue;
      const int dx = static_cast<int>(i) % window.side, dy = static_cast<int>(i) / window.side;
      BevPeak peak;
      peak.x_m = options.cell_m * (window.centre_x - window.half + dx);
      peak.y_m = options.cell_m * (window.centre_y - window.half + dy);
      peak.yaw_rad = scores.yaw_rad[k];
      peak.score = scores.of_yaw[k][i] / (kHit * static_cast<double>(source_cells));
      if (IsShoulder(peak, found, options)) continue;
      best = peak;
      best_score = scores.of_yaw[k][i];
    }
  }
  return best;
}

std::vector<double> YawsOf(const BevSearch& search, double step_rad) {
  const double window_rad = std::min(search.yaw_window_rad, kPi);
  const int steps = static_cast<int>(std::ceil(window_rad / step_rad - 1e-9));
  std::vector<double> yaws;
  for (int i = -steps; i <= steps; ++i) yaws.push_back(search.yaw_rad + i * step_rad);
  return yaws;
}

}  // namespace

void BevAlignmentOptions::Check() const {
  TVL_CHECK_INPUT(cell_m > 0.05) << "bev_alignment.cell_m: must exceed 0.05";
  TVL_CHECK_INPUT(yaw_step_rad > 1e-3) << "bev_alignment.yaw_step_rad: must exceed 0.001";
  TVL_CHECK_INPUT(range_m > cell_m) << "bev_alignment.range_m: must exceed cell_m";
  TVL_CHECK_INPUT(peak_distance_m > 0.0 && peak_yaw_rad > 0.0)
      << "bev_alignment.peak_distance_m, peak_yaw_rad: must be positive";
  TVL_CHECK_INPUT(peaks >= 1) << "bev_alignment.peaks: must be at least 1";
}

std::vector<char> AboveGround(const std::vector<Eigen::Vector3f>& points, double height_m) {
  constexpr double kColumn_m = 1.0;
  struct Column {
    size_t index = kNoColumn;
    float lowest = std::numeric_limits<float>::infinity();
  };
  VoxelHash<Column> columns;
  std::vector<size_t> column_of(points.size());
  VoxelKey last_key;
  Column* last = nullptr;  // neighbours in a scan often share a column
  for (size_t i = 0; i < points.size(); ++i) {
    const VoxelKey key = VoxelKey::Of({points[i].x(), points[i].y(), 0.0}, kColumn_m);
    if (last == nullptr || !(key == last_key)) last = &columns[key];
    last_key = key;
    if (last->index == kNoColumn) last->index = columns.size() - 1;
    column_of[i] = last->index;
    last->lowest = std::min(last->lowest, points[i].z());
  }
  std::vector<float> ground_m(columns.size(), std::numeric_limits<float>::infinity());
  for (const auto& entry : columns.entries()) {
    float& lowest = ground_m[entry.value.index];
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Column* beside = columns.Find({entry.key.x + dx, entry.key.y + dy, 0});
        if (beside != nullptr) lowest = std::min(lowest, beside->lowest);
      }
    }
  }
  std::vector<char> raised(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    raised[i] = points[i].z() - ground_m[column_of[i]] > height_m ? 1 : 0;
  }
  return raised;
}

std::vector<BevPeak> AlignBev(const std::vector<Eigen::Vector2f>& target,
                              const std::vector<Eigen::Vector2f>& source, const BevSearch& search,
                              const BevAlignmentOptions& options, const Executor& executor) {
  options.Check();
  const std::vector<Eigen::Vector2f> thin = ThinToCells(source, options);
  TVL_CHECK(kHit * thin.size() < 65536) << "range_m / cell_m is too large";
  Window window;
  window.half = static_cast<int>(std::ceil(search.radius_m / options.cell_m));
  window.side = 2 * window.half + 1;
  window.centre_x = static_cast<int>(std::lround(search.x_m / options.cell_m));
  window.centre_y = static_cast<int>(std::lround(search.y_m / options.cell_m));
  const int reach = static_cast<int>(std::ceil(options.range_m / options.cell_m)) + window.half +
                    std::max(std::abs(window.centre_x), std::abs(window.centre_y)) + 3;
  const TargetGrid grid(target, reach, options.cell_m);
  Scores scores;
  scores.yaw_rad = YawsOf(search, options.yaw_step_rad);
  scores.of_yaw.resize(scores.yaw_rad.size());
  executor.For(scores.yaw_rad.size(), 1, [&](size_t k, size_t) {
    scores.of_yaw[k] = ScoreShifts(grid, thin, scores.yaw_rad[k], window, options.cell_m);
  });
  std::vector<BevPeak> peaks;
  while (static_cast<int>(peaks.size()) < options.peaks) {
    const BevPeak peak = NextPeak(scores, window, thin.size(), peaks, options);
    if (peak.score <= 0.0) break;
    peaks.push_back(peak);
  }
  return peaks;
}

}  // namespace tvl
