#include "tvl/lidar/ground.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr float kUnknownSlope = 1e3f;
constexpr float kFlatRun_m = 0.3f;  // over this the noise of two heights is some degrees

// Horizontal distance and height of a cell's point, m; h == 0: no point.
struct Cell {
  float h = 0, z = 0;
};

// The ground last seen in a column.
struct ColumnGround {
  float h = 0, z = 0, slope = 0;
};

// Thresholds as floats.
struct Limits {
  explicit Limits(const GroundOptions& o)
      : slope(static_cast<float>(std::tan(o.max_slope_rad))),
        step_m(static_cast<float>(o.max_step_m)),
        noise_m(static_cast<float>(o.height_noise_m)),
        steep(static_cast<float>(std::tan(o.steep_rad))) {}
  float slope, step_m, noise_m, steep;
};

std::vector<Cell> MakeCells(const SegmentedScan& scan) {
  const RangeImage& image = scan.image;
  std::vector<Cell> cells(image.point.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    if (image.point[i] == RangeImage::kNoPoint) continue;
    const Eigen::Vector3f& p = scan.points[static_cast<size_t>(image.point[i])];
    cells[i] = {std::sqrt(p.x() * p.x() + p.y() * p.y()), p.z()};
  }
  return cells;
}

// Slope from cell `i` outwards, along its column; looks up to six rows up.
float SlopeAhead(const std::vector<Cell>& cells, size_t i, size_t columns) {
  const Cell& cell = cells[i];
  for (size_t up = columns; up <= 6 * columns && up <= i; up += columns) {
    const Cell& above = cells[i - up];
    if (above.h == 0.0f) continue;
    const float run = above.h - cell.h;
    if (run >= kFlatRun_m) return (above.z - cell.z) / run;
    if (run < -kFlatRun_m) break;  // something overhangs
  }
  return kUnknownSlope;
}

// Does the nearest point above, at most two rows up (one may have got no return), stand over it?
bool IsSteep(const std::vector<Cell>& cells, size_t i, size_t columns, const Limits& limits) {
  for (size_t up = columns; up <= 2 * columns && up <= i; up += columns) {
    const Cell& above = cells[i - up];
    if (above.h == 0.0f) continue;
    const float run = std::abs(above.h - cells[i].h);
    return above.z - cells[i].z > limits.steep * run + limits.noise_m;
  }
  return false;
}

// Moves the column's ground on to an accepted point. Not by less than kStride_m: noise on short
// steps, each within its tolerance, would climb any bank.
void Advance(const Cell& cell, ColumnGround* ground) {
  constexpr float kStride_m = 0.4f;
  constexpr float kSlopeMemory_m = 3.0f;  // a slope over a few metres counts
  const float run = cell.h - ground->h;
  if (run < kStride_m) return;
  const float deviation = cell.z - (ground->z + ground->slope * run);
  const float weight = run / (run + kSlopeMemory_m);
  ground->slope = std::clamp(ground->slope + weight * deviation / run, -0.5f, 0.5f);
  ground->z = cell.z - 0.3f * deviation * (1.0f - weight);
  ground->h = cell.h;
}

std::vector<ColumnGround> SeedColumns(const RangeImage& image, const GroundSeed& seed) {
  std::vector<ColumnGround> columns(static_cast<size_t>(image.columns));
  for (size_t c = 0; c < columns.size(); ++c) {
    const double azimuth =
        3.14159265358979 * (1.0 - 2.0 * (static_cast<double>(c) + 0.5) / image.columns);
    columns[c].z = seed.c;
    columns[c].slope = seed.a * static_cast<float>(std::cos(azimuth)) +
                       seed.b * static_cast<float>(std::sin(azimuth));
  }
  return columns;
}

// Grows through the rows, the lowest first.
class Grower {
 public:
  Grower(const SegmentedScan& scan, const GroundOptions& options, const GroundSeed& seed)
      : scan_(scan),
        limits_(options),
        width_(static_cast<size_t>(scan.image.columns)),
        cells_(MakeCells(scan)),
        columns_(SeedColumns(scan.image, seed)),
        is_ground_(scan.size(), 0),
        row_ground_(width_, 0) {}

  std::vector<uint8_t> Grow() {
    for (int row = scan_.image.rows - 1; row >= 0; --row) {
      const size_t first = scan_.image.Index(row, 0);
      GrowColumns(first);
      for (const size_t c : open_) GrowSideways(first, c, width_ - 1);
      std::reverse(open_.begin(), open_.end());
      for (const size_t c : open_) GrowSideways(first, c, 1);
    }
    return std::move(is_ground_);
  }

 private:
  // Does the surface at the cell run on like the column's ground?
  bool IsFlat(size_t i, const ColumnGround& ground) const {
    return std::abs(SlopeAhead(cells_, i, width_) - ground.slope) <= limits_.slope;
  }

  // Does the point of a cell, `deviation` above the continued ground of its column, belong to it?
  bool Continues(size_t i, const ColumnGround& ground, float deviation) const {
    const float run = cells_[i].h - ground.h;
    if (run < -limits_.noise_m || std::abs(deviation) > limits_.step_m) return false;
    const float tolerance = limits_.slope * std::max(run, 0.0f) + limits_.noise_m;
    if (std::abs(deviation) <= tolerance &&
        (deviation <= 2.0f * limits_.noise_m || !IsSteep(cells_, i, width_, limits_))) {
      return true;
    }
    // The top of a kerb is no slope: what matters is how the surface runs on.
    return IsFlat(i, ground);
  }

  void Accept(size_t i, size_t c) {
    is_ground_[static_cast<size_t>(scan_.image.point[i])] = 1;
    row_ground_[c] = 1;
    Advance(cells_[i], &columns_[c]);
  }

  // Leaves in open_ the columns whose point may still be ground for its neighbours' sake.
  void GrowColumns(size_t first) {
    open_.clear();
    for (size_t c = 0; c < width_; ++c) {
      row_ground_[c] = 0;
      const Cell& cell = cells_[first + c];
      if (cell.h == 0.0f) continue;
      const ColumnGround& ground = columns_[c];
      const float run = cell.h - ground.h;
      const float deviation = cell.z - (ground.z + ground.slope * run);
      if (Continues(first + c, ground, deviation)) {
        Accept(first + c, c);
      } else if (run >= 0.0f &&
                 std::abs(deviation) <= limits_.step_m + 0.5f * limits_.slope * run) {
        open_.push_back(c);
      }
    }
  }

  // Column `c` joins the ground nearest to it in the ring, `direction` columns on (modulo width).
  void GrowSideways(size_t first, size_t c, size_t direction) {
    constexpr int kReach = 4;  // columns to the last ground point
    if (row_ground_[c]) return;
    size_t other = c;
    int k = 0;
    do {
      other = (other + direction) % width_;
      if (++k > kReach) return;
    } while (!row_ground_[other]);
    if (ContinuesSideways(first + c, first + other, columns_[c])) Accept(first + c, c);
  }

  bool ContinuesSideways(size_t i, size_t neighbour, const ColumnGround& ground) const {
    const auto point = [&](size_t cell) -> const Eigen::Vector3f& {
      return scan_.points[static_cast<size_t>(scan_.image.point[cell])];
    };
    const Eigen::Vector3f d = point(i) - point(neighbour);
    const float run = std::sqrt(d.x() * d.x() + d.y() * d.y());
    if (std::abs(d.z()) > std::min(limits_.step_m, limits_.slope * run + limits_.noise_m)) {
      return false;
    }
    // Where the column itself has seen the ground a moment ago, it knows better.
    constexpr float kRecent_m = 2.0f;
    if (cells_[i].h - ground.h < kRecent_m && !IsFlat(i, ground)) return false;
    return !IsSteep(cells_, i, width_, limits_);
  }

  const SegmentedScan& scan_;
  const Limits limits_;
  const size_t width_;
  const std::vector<Cell> cells_;
  std::vector<ColumnGround> columns_;
  std::vector<uint8_t> is_ground_;
  std::vector<uint8_t> row_ground_;  // of the row at hand, by column
  std::vector<size_t> open_;         // columns of the row at hand
};

}  // namespace

void GroundOptions::Check() const {
  TVL_CHECK_INPUT(max_slope_rad > 0.0 && max_slope_rad < 0.8)
      << "ground.max_slope_deg: want 0..45, is " << max_slope_rad << " rad";
  TVL_CHECK_INPUT(max_step_m > 0.0) << "ground.max_step_m: must be positive";
  TVL_CHECK_INPUT(height_noise_m >= 0.0) << "ground.height_noise_m: must not be negative";
  TVL_CHECK_INPUT(steep_rad > max_slope_rad && steep_rad < 1.5)
      << "ground.steep_deg: must be above max_slope_deg and below 86 deg";
  TVL_CHECK_INPUT(seed_radius_m > 0.0) << "ground.seed_radius_m: must be positive";
  TVL_CHECK_INPUT(max_seed_tilt_rad > 0.0 && max_seed_tilt_rad < 0.8)
      << "ground.max_seed_tilt_deg: want 0..45, is " << max_seed_tilt_rad << " rad";
  TVL_CHECK_INPUT(seed_tolerance_m > 0.0) << "ground.seed_tolerance_m: must be positive";
  TVL_CHECK_INPUT(min_seed_points >= 3) << "ground.min_seed_points: must be at least 3";
}

GroundResult FindGround(const SegmentedScan& scan, const GroundOptions& options) {
  GroundResult result;
  result.seed = FindGroundSeed(scan, options);
  if (!result.seed.found) {
    result.is_ground.assign(scan.size(), 0);
    return result;
  }
  result.is_ground = Grower(scan, options, result.seed).Grow();
  result.count =
      static_cast<int>(std::count(result.is_ground.begin(), result.is_ground.end(), uint8_t{1}));
  return result;
}

}  // namespace tvl
