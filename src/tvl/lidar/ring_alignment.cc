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

// What an empty row costs, rad^2, by where it is.
struct EmptyRowPenalty {
  double before = 0.0;   // the first ring
  double between = 0.0;  // two rings
  double after = 0.0;    // the last ring
};

struct Path {
  double cost = 0.0;
  std::vector<int> row;
};

// The cheapest way through (ring, row): squared elevation differences and the penalties.
Path CheapestPath(const std::vector<double>& ring_rad, const std::vector<double>& beam_rad,
                  double offset_rad, const EmptyRowPenalty& empty) {
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
      above += k == 0 ? empty.before : empty.between;
      if (k > 0 && cost[r] < above) {
        above = cost[r];
        above_row = static_cast<int>(r);
      }
    }
    cost.swap(next);
  }
  for (size_t r = 0; r < rows; ++r) cost[r] += empty.after * static_cast<double>(rows - 1 - r);
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

constexpr double kHeightStep_m = 0.02, kHighestOrigin_m = 0.24;

// Elevation of a ring as seen from `height_m` above the sensor's origin.
std::vector<double> Elevations(const std::vector<RingProfile>& rings, double height_m) {
  std::vector<double> elevations_rad;
  elevations_rad.reserve(rings.size());
  for (const RingProfile& ring : rings) {
    elevations_rad.push_back(std::atan2(ring.height_m - height_m, ring.distance_m));
  }
  return elevations_rad;
}

// Beams whose origin lies up to kHighestOrigin_m above the sensor's appear higher than they look,
// rings nearby by 2 deg; nominal elevations are off by 1 deg at most.
bool ReachesLowestBeam(const std::vector<RingProfile>& rings,
                       const std::vector<double>& beam_elevation_rad) {
  const double lowest_rad = Elevations({rings.back()}, 0.5 * kHighestOrigin_m).front();
  return lowest_rad < beam_elevation_rad.back() + DegToRad(1.5);
}

}  // namespace

RingAlignment AlignRingsToBeams(const std::vector<RingProfile>& rings,
                                const std::vector<double>& beam_elevation_rad) {
  TVL_CHECK(!rings.empty() && !beam_elevation_rad.empty());
  constexpr double kRefused = 1.0;   // rad^2: more than any path costs
  constexpr double kBetween = 1e-4;  // a few rings that would otherwise be one row off
  // Less than between two rings by (0.3 deg)^2: one ring that would otherwise be one row off.
  constexpr double kBefore = kBetween - 3e-5;
  std::vector<EmptyRowPenalty> ends = {{kBetween, kBetween, 0.0}};  // the file was cut off
  if (ReachesLowestBeam(rings, beam_elevation_rad)) {
    ends.push_back({kBefore, kBetween, kRefused});  // upper beams looked at the sky
  }
  const double count = static_cast<double>(rings.size());
  RingAlignment best;
  double best_score = std::numeric_limits<double>::infinity();
  for (double height_m = 0.0; height_m < kHighestOrigin_m + 0.01; height_m += kHeightStep_m) {
    const std::vector<double> elevation_rad = Elevations(rings, height_m);
    for (int step = -20; step <= 20; ++step) {
      const double offset_rad = DegToRad(0.05 * step);
      for (const EmptyRowPenalty& empty : ends) {
        Path path = CheapestPath(elevation_rad, beam_elevation_rad, offset_rad, empty);
        // Neither is free: among like fits the smaller wins.
        const double score =
            path.cost / count + 0.01 * offset_rad * offset_rad + 1e-6 * height_m * height_m;
        if (score >= best_score) continue;
        best_score = score;
        best = {std::move(path.row), offset_rad, height_m, std::sqrt(path.cost / count)};
      }
    }
  }
  return best;
}

RingAlignment AlignRingsToScan(const std::vector<RingProfile>& rings,
                               const std::vector<RingProfile>& complete) {
  TVL_CHECK(!rings.empty() && !complete.empty());
  constexpr double kBetween = 3e-5;  // (0.3 deg)^2: one ring that would otherwise be one row off
  const double count = static_cast<double>(rings.size());
  RingAlignment best;
  best.rms_rad = std::numeric_limits<double>::infinity();
  for (double height_m = 0.0; height_m < kHighestOrigin_m + 0.01; height_m += kHeightStep_m) {
    Path path = CheapestPath(Elevations(rings, height_m), Elevations(complete, height_m), 0.0,
                             {0.0, kBetween, 0.0});
    const double rms_rad = std::sqrt(path.cost / count);
    if (rms_rad >= best.rms_rad) continue;
    best = {std::move(path.row), 0.0, height_m, rms_rad};
  }
  return best;
}

}  // namespace tvl
