#include "tvl/lidar/ground.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr float kUnknownSlope = 1e3f;
constexpr float kFlatRun_m = 0.3f;  // over this the noise of two heights is some degrees

// What growing needs of a cell.
struct Cell {
  float h = 0, z = 0;                 // horizontal distance and height, m; h == 0: no point
  bool steep = false;                 // the point above it stands over it
  float slope_ahead = kUnknownSlope;  // to the next point kFlatRun_m or more farther out
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

std::vector<Cell> MakeCells(const SegmentedScan& scan, const Limits& limits) {
  const RangeImage& image = scan.image;
  std::vector<Cell> cells(image.point.size());
  const size_t columns = static_cast<size_t>(image.columns);
  for (size_t i = 0; i < cells.size(); ++i) {  // from the top: those above are known
    if (image.point[i] == RangeImage::kNoPoint) continue;
    const Eigen::Vector3f& p = scan.points[static_cast<size_t>(image.point[i])];
    cells[i].h = std::sqrt(p.x() * p.x() + p.y() * p.y());
    cells[i].z = p.z();
    cells[i].steep = IsSteep(cells, i, columns, limits);
    cells[i].slope_ahead = SlopeAhead(cells, i, columns);
  }
  return cells;
}

// Does the surface at the point run on like the column's ground?
bool IsFlat(const Cell& cell, const ColumnGround& ground, const Limits& limits) {
  return std::abs(cell.slope_ahead - ground.slope) <= limits.slope;
}

// Does the point continue the column's ground?
bool Continues(const Cell& cell, const ColumnGround& ground, const Limits& limits) {
  const float run = cell.h - ground.h;
  if (run < -limits.noise_m) return false;
  const float deviation = cell.z - (ground.z + ground.slope * run);
  // The top of a kerb is no slope: what matters is how the surface runs on.
  if (std::abs(deviation) <= limits.step_m && IsFlat(cell, ground, limits)) return true;
  const float tolerance =
      std::min(limits.step_m, limits.slope * std::max(run, 0.0f) + limits.noise_m);
  if (std::abs(deviation) > tolerance) return false;
  return !(cell.steep && deviation > 2.0f * limits.noise_m);
}

// Does the point continue its neighbour in the ring?
bool ContinuesSideways(const SegmentedScan& scan, size_t index, size_t neighbour, const Cell& cell,
                       const ColumnGround& ground, const Limits& limits) {
  if (cell.steep) return false;
  const Eigen::Vector3f d = scan.points[index] - scan.points[neighbour];
  const float run = std::sqrt(d.x() * d.x() + d.y() * d.y());
  if (std::abs(d.z()) > std::min(limits.step_m, limits.slope * run + limits.noise_m)) return false;
  // Where the column itself has seen the ground a moment ago, it knows better.
  constexpr float kRecent_m = 2.0f;
  const float ahead = cell.h - ground.h;
  if (ahead < 0.0f || (ahead < kRecent_m && !IsFlat(cell, ground, limits))) return false;
  const float deviation = cell.z - (ground.z + ground.slope * ahead);
  return std::abs(deviation) <= limits.step_m + 0.5f * limits.slope * ahead;
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
        cells_(MakeCells(scan, limits_)),
        columns_(SeedColumns(scan.image, seed)),
        is_ground_(scan.size(), 0) {}

  std::vector<uint8_t> Grow() {
    for (int row = scan_.image.rows - 1; row >= 0; --row) {
      GrowColumns(row);
      GrowSideways(row, +1);
      GrowSideways(row, -1);
    }
    return std::move(is_ground_);
  }

 private:
  void Accept(size_t index, const Cell& cell, size_t column) {
    is_ground_[index] = 1;
    Advance(cell, &columns_[column]);
  }

  void GrowColumns(int row) {
    const size_t first = scan_.image.Index(row, 0);
    for (size_t c = 0; c < columns_.size(); ++c) {
      const Cell& cell = cells_[first + c];
      if (cell.h == 0.0f || !Continues(cell, columns_[c], limits_)) continue;
      Accept(static_cast<size_t>(scan_.image.point[first + c]), cell, c);
    }
  }

  void GrowSideways(int row, int direction) {
    constexpr int kReach = 4;  // columns to the last ground point
    const int n = scan_.image.columns;
    const size_t first = scan_.image.Index(row, 0);
    int since = kReach + 1;
    size_t last = 0;
    for (int k = 0; k < n + kReach; ++k, ++since) {  // a little beyond once round
      const size_t c = static_cast<size_t>(direction > 0 ? k % n : (2 * n - 1 - k) % n);
      const Cell& cell = cells_[first + c];
      if (cell.h == 0.0f) continue;
      const size_t index = static_cast<size_t>(scan_.image.point[first + c]);
      if (!is_ground_[index]) {
        if (since > kReach) continue;
        if (!ContinuesSideways(scan_, index, last, cell, columns_[c], limits_)) continue;
        Accept(index, cell, c);
      }
      last = index;
      since = 0;
    }
  }

  const SegmentedScan& scan_;
  const Limits limits_;
  const std::vector<Cell> cells_;
  std::vector<ColumnGround> columns_;
  std::vector<uint8_t> is_ground_;
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
