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
// Fewer source cells on known ground than this share say nothing.
constexpr double kMinKnownShare = 0.2;
// What lies up to this far from an alignment is what it must exceed: a parked car's length.
constexpr double kBeside_m = 4.0;

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
  // 1 in all cells of the squares about `middles`.
  static TargetGrid Squares(const std::vector<Eigen::Vector2f>& middles, double square_m, int half,
                            double cell_m) {
    TargetGrid grid({}, half, cell_m);
    const auto reach_m = static_cast<float>(0.5 * square_m);
    for (const Eigen::Vector2f& p : middles) {
      const int x0 = CellOf(p.x() - reach_m, cell_m), x1 = CellOf(p.x() + reach_m, cell_m);
      const int y0 = CellOf(p.y() - reach_m, cell_m), y1 = CellOf(p.y() + reach_m, cell_m);
      for (int y = std::max(y0, -half); y < std::min(y1, half); ++y) {
        for (int x = std::max(x0, -half); x < std::min(x1, half); ++x) {
          grid.weights_[grid.Index(x, y)] = 1;
        }
      }
    }
    return grid;
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
  std::vector<std::vector<uint16_t>> known;  // source cells on known ground; empty: all
  std::vector<std::vector<float>> rank;      // where `known` counts: what alignments are ranked by
  size_t source_cells = 0;

  double Rank(size_t yaw, size_t shift) const {
    return known.empty() ? of_yaw[yaw][shift] : static_cast<double>(rank[yaw][shift]);
  }
  double Share(size_t yaw, size_t shift) const {
    const double cells =
        known.empty() ? static_cast<double>(source_cells) : static_cast<double>(known[yaw][shift]);
    return of_yaw[yaw][shift] / (kHit * std::max(1.0, cells));
  }
};

// Sums over squares of a plane of values.
class SquareSums {
 public:
  SquareSums(const std::vector<uint16_t>& values, int side)
      : side_(side), sums_(static_cast<size_t>((side + 1) * (side + 1)), 0.0) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        At(x + 1, y + 1) =
            values[static_cast<size_t>(y * side + x)] + At(x, y + 1) + At(x + 1, y) - At(x, y);
      }
    }
  }
  double Around(int x, int y, int reach) {
    const int x0 = std::max(0, x - reach), x1 = std::min(side_, x + reach + 1);
    const int y0 = std::max(0, y - reach), y1 = std::min(side_, y + reach + 1);
    return At(x1, y1) - At(x0, y1) - At(x1, y0) + At(x0, y0);
  }

 private:
  double& At(int x, int y) { return sums_[static_cast<size_t>(y * (side_ + 1) + x)]; }
  int side_;
  std::vector<double> sums_;
};

// By how much an alignment exceeds those a little beside it, in standard errors. What stands along
// a street meets itself after any shift, and the more the better the map knows the place; the right
// alignment stands out from its surroundings.
std::vector<float> RankShifts(const std::vector<uint16_t>& met, const std::vector<uint16_t>& known,
                              int side, int reach, size_t source_cells) {
  SquareSums met_sums(met, side), known_sums(known, side);
  std::vector<float> rank(met.size(), 0.0f);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto i = static_cast<size_t>(y * side + x);
      const double on_known = known[i];
      if (on_known < kMinKnownShare * static_cast<double>(source_cells)) continue;
      const double usual =
          met_sums.Around(x, y, reach) / std::max(1.0, known_sums.Around(x, y, reach));
      rank[i] = static_cast<float>((met[i] - usual * on_known) / std::sqrt(on_known));
    }
  }
  return rank;
}

// The best alignment that is no shoulder of those found; its score is 0 if there is none.
BevPeak NextPeak(const Scores& scores, const Window& window, const std::vector<BevPeak>& found,
                 const BevAlignmentOptions& options) {
  BevPeak best;
  double best_rank = 0.0;
  for (size_t k = 0; k < scores.of_yaw.size(); ++k) {
    for (size_t i = 0; i < scores.of_yaw[k].size(); ++i) {
      const double rank = scores.Rank(k, i);
      if (rank <= best_rank) continue;
      const int dx = static_cast<int>(i) % window.side, dy = static_cast<int>(i) / window.side;
      BevPeak peak;
      peak.x_m = options.cell_m * (window.centre_x - window.half + dx);
      peak.y_m = options.cell_m * (window.centre_y - window.half + dy);
      peak.yaw_rad = scores.yaw_rad[k];
      peak.score = scores.Share(k, i);
      if (IsShoulder(peak, found, options)) continue;
      best = peak;
      best_rank = rank;
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
  return AlignBevToKnown(BevTarget{target, {}, 2.0}, source, search, options, executor);
}

std::vector<BevPeak> AlignBevToKnown(const BevTarget& target,
                                     const std::vector<Eigen::Vector2f>& source,
                                     const BevSearch& search, const BevAlignmentOptions& options,
                                     const Executor& executor) {
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
  const TargetGrid grid(target.raised, reach, options.cell_m);
  const TargetGrid known = TargetGrid::Squares(target.known, target.known_m, reach, options.cell_m);
  Scores scores;
  scores.source_cells = thin.size();
  scores.yaw_rad = YawsOf(search, options.yaw_step_rad);
  scores.of_yaw.resize(scores.yaw_rad.size());
  if (!target.known.empty()) {
    scores.known.resize(scores.yaw_rad.size());
    scores.rank.resize(scores.yaw_rad.size());
  }
  const int beside = static_cast<int>(std::lround(kBeside_m / options.cell_m));
  executor.For(scores.yaw_rad.size(), 1, [&](size_t k, size_t) {
    const double yaw_rad = scores.yaw_rad[k];
    scores.of_yaw[k] = ScoreShifts(grid, thin, yaw_rad, window, options.cell_m);
    if (scores.known.empty()) return;
    scores.known[k] = ScoreShifts(known, thin, yaw_rad, window, options.cell_m);
    scores.rank[k] =
        RankShifts(scores.of_yaw[k], scores.known[k], window.side, beside, thin.size());
  });
  std::vector<BevPeak> peaks;
  while (static_cast<int>(peaks.size()) < options.peaks) {
    const BevPeak peak = NextPeak(scores, window, peaks, options);
    if (peak.score <= 0.0) break;
    peaks.push_back(peak);
  }
  return peaks;
}

}  // namespace tvl
