#include "tvl/lidar/ring_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// Squares of angles, rad^2.
constexpr double kSharedRowPenalty = 1e-3;  // (1.8 deg)^2: more than any real mismatch
constexpr double kEmptyRowPenalty = 1e-4;   // a few rings that would otherwise be one row off

struct Path {
  double cost = 0.0;
  std::vector<int> row;
};

// The cheapest way through (ring, row): squared elevation differences and the penalties above.
Path CheapestPath(const std::vector<double>& ring_rad, const std::vector<double>& beam_rad,
                  double offset_rad) {
  const size_t rings = ring_rad.size(), rows = beam_rad.size();
  std::vector<double> cost(rows), next(rows);
  std::vector<int> from(rings * rows, -1);
  for (size_t k = 0; k < rings; ++k) {
    // The cheapest way into the row from one above it; before the first ring all rows are empty.
    double above = k == 0 ? 0.0 : std::numeric_limits<double>::infinity();
    int above_row = -1;
    for (size_t r = 0; r < rows; ++r) {
      const double shared =
          k == 0 ? std::numeric_limits<double>::infinity() : cost[r] + kSharedRowPenalty;
      from[k * rows + r] = shared < above ? static_cast<int>(r) : above_row;
      const double d = ring_rad[k] - offset_rad - beam_rad[r];
      next[r] = std::min(shared, above) + d * d;
      above += kEmptyRowPenalty;
      if (k > 0 && cost[r] < above) {
        above = cost[r];
        above_row = static_cast<int>(r);
      }
    }
    cost.swap(next);
  }
  const auto last = std::min_element(cost.begin(), cost.end());
  Path path;
  path.cost = *last;
  path.row.resize(rings);
  int r = static_cast<int>(last - cost.begin());
  for (size_t k = rings; k-- > 0;) {
    path.row[k] = r;
    r = from[k * rows + static_cast<size_t>(r)];
  }
  return path;
}

}  // namespace

RingAlignment AlignRingsToBeams(const std::vector<RingProfile>& rings,
                                const std::vector<double>& beam_elevation_rad) {
  TVL_CHECK(!rings.empty() && !beam_elevation_rad.empty());
  const double count = static_cast<double>(rings.size());
  RingAlignment best;
  double best_score = std::numeric_limits<double>::infinity();
  std::vector<double> elevation_rad(rings.size());
  for (int height_step = 0; height_step <= 12; ++height_step) {
    const double height_m = 0.02 * height_step;
    for (size_t k = 0; k < rings.size(); ++k) {
      elevation_rad[k] = std::atan2(rings[k].height_m - height_m, rings[k].distance_m);
    }
    for (int step = -20; step <= 20; ++step) {
      const double offset_rad = DegToRad(0.05 * step);
      Path path = CheapestPath(elevation_rad, beam_elevation_rad, offset_rad);
      // Neither is free: among like fits the smaller wins.
      const double score =
          path.cost / count + 1e-3 * offset_rad * offset_rad + 1e-6 * height_m * height_m;
      if (score >= best_score) continue;
      best_score = score;
      best = {std::move(path.row), offset_rad, height_m, std::sqrt(path.cost / count)};
    }
  }
  return best;
}

}  // namespace tvl
