#include "tvl/lidar/stored_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tvl/base/units.h"
#include "tvl/lidar/beam_elevations.h"
#include "tvl/lidar/scan_geometry.h"

namespace tvl {
namespace {

constexpr int kAzimuthBins = 360;
constexpr double kBin_rad = 2.0 * kPi / kAzimuthBins;

double Wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

int BinOf(double azimuth_rad) {
  const int bin = static_cast<int>(std::floor((azimuth_rad + kPi) / kBin_rad));
  return (bin % kAzimuthBins + kAzimuthBins) % kAzimuthBins;
}

struct Direction {
  double azimuth_rad, elevation_rad;
};

std::vector<Direction> Directions(const RawScan& scan, float min_range) {
  std::vector<Direction> out;
  out.reserve(scan.size());
  for (const Eigen::Vector3f& p : scan.points) {
    if (!IsReturn(p, min_range)) continue;
    out.push_back(
        {static_cast<double>(FastAtan2(p.y(), p.x())), static_cast<double>(Elevation_rad(p))});
  }
  return out;
}

constexpr int kSmallestGap = 10;  // bins

// Middle bin of the largest range of azimuth without points; -1 if there is none to speak of.
int LargestGap(const std::vector<Direction>& directions) {
  std::array<bool, kAzimuthBins> seen{};
  for (const Direction& d : directions) seen[static_cast<size_t>(BinOf(d.azimuth_rad))] = true;
  int longest = 0, middle = -1, run = 0;
  for (int i = 0; i < 2 * kAzimuthBins; ++i) {  // twice, for a gap across the end
    run = seen[static_cast<size_t>(i % kAzimuthBins)] ? 0 : run + 1;
    if (run <= longest || run > kAzimuthBins) continue;
    longest = run;
    middle = (i - run / 2) % kAzimuthBins;
  }
  return longest >= kSmallestGap ? middle : -1;
}

constexpr size_t kChunks = 16;

// +1 where the median elevation rises from each sixteenth of the points to the next, -1 where it
// falls, but for one of them; 0 for neither.
int ElevationTrend(const std::vector<Direction>& directions) {
  std::vector<double> medians;
  for (size_t chunk = 0; chunk < kChunks; ++chunk) {
    std::vector<double> values;
    const size_t end = (chunk + 1) * directions.size() / kChunks;
    for (size_t i = chunk * directions.size() / kChunks; i < end; ++i) {
      values.push_back(directions[i].elevation_rad);
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    medians.push_back(*middle);
  }
  size_t rising = 0;
  for (size_t i = 1; i < kChunks; ++i) rising += medians[i] > medians[i - 1];
  if (rising >= kChunks - 2) return 1;
  return rising <= 1 ? -1 : 0;
}

// Share of the passes of each bin of azimuth in which the elevation steps as from one ring to the
// next.
std::vector<double> StartScores(const std::vector<Direction>& directions, int gap, int trend) {
  std::vector<std::vector<double>> passes(kAzimuthBins);
  int current = -1;
  double lowest = directions[0].elevation_rad, highest = lowest, turned_rad = 0.0;
  for (size_t i = 1; i < directions.size(); ++i) {
    const Direction& a = directions[i - 1];
    const Direction& b = directions[i];
    const double step = Wrapped(b.azimuth_rad - a.azimuth_rad);
    turned_rad += std::abs(step);
    lowest = std::min(lowest, b.elevation_rad), highest = std::max(highest, b.elevation_rad);
    const bool jumps = gap >= 0 && std::abs(step) > kSmallestGap * kBin_rad;
    const int bin = jumps ? gap : BinOf(Wrapped(a.azimuth_rad + 0.5 * step));
    if (bin != current) passes[static_cast<size_t>(bin)].push_back(0.0);
    passes[static_cast<size_t>(bin)].back() += trend * (b.elevation_rad - a.elevation_rad);
    current = bin;
  }
  const double turns = std::max(turned_rad / (2.0 * kPi), 1.0);
  const double spacing_rad = (highest - lowest) / turns;
  std::vector<double> scores;
  for (const std::vector<double>& pass : passes) {
    const auto steps = std::count_if(pass.begin(), pass.end(), [&](double rise_rad) {
      return rise_rad > 0.3 * spacing_rad && rise_rad < 4.0 * spacing_rad;
    });
    const bool tells = static_cast<double>(pass.size()) > 0.25 * turns;
    scores.push_back(tells ? static_cast<double>(steps) / static_cast<double>(pass.size()) : 0.0);
  }
  return scores;
}

}  // namespace

std::optional<RingOrder> FindRingOrder(const RawScan& scan, float min_range) {
  const std::vector<Direction> directions = Directions(scan, min_range);
  if (directions.size() < kChunks) return std::nullopt;
  const int gap = LargestGap(directions);
  // Within a ring the azimuth goes one way. Steps are small there; others leave out what has no
  // return, or lead to the next ring.
  constexpr double kSmallStep_rad = 0.1, kOneWay = 0.9;
  size_t small = 0, rising = 0, falling = 0, jumps = 0;
  double turns = 0.0;
  for (size_t i = 1; i < directions.size(); ++i) {
    const double step = Wrapped(directions[i].azimuth_rad - directions[i - 1].azimuth_rad);
    turns += step / (2.0 * kPi);
    if (std::abs(step) > kSmallestGap * kBin_rad) ++jumps;
    if (std::abs(step) > kSmallStep_rad) continue;
    ++small;
    if (step != 0.0) ++(step > 0.0 ? rising : falling);
  }
  const double one_way = kOneWay * static_cast<double>(small);
  if (static_cast<double>(std::max(rising, falling)) < one_way) return std::nullopt;
  // A sensor that does not see all round jumps back across what it does not see.
  constexpr double kFewestRings = 4.0;
  if (gap < 0 && std::abs(turns) < kFewestRings - 0.5) return std::nullopt;
  if (gap >= 0 && static_cast<double>(jumps) < kFewestRings - 1.0) return std::nullopt;
  const int trend = ElevationTrend(directions);
  if (trend == 0) return std::nullopt;
  return RingOrder{trend > 0, StartScores(directions, gap, trend)};
}

double RingStart_rad(const std::vector<RingOrder>& orders) {
  std::array<double, kAzimuthBins> score{};
  for (const RingOrder& order : orders) {
    for (size_t i = 0; i < score.size(); ++i) score[i] += order.start_score[i];
  }
  const auto near = [&](int bin) {  // rings begin within a bin or two of each other
    double best = 0.0;
    for (int k = -2; k <= 2; ++k) {
      best = std::max(best, score[static_cast<size_t>((bin + k + kAzimuthBins) % kAzimuthBins)]);
    }
    return best;
  };
  const size_t best =
      static_cast<size_t>(std::max_element(score.begin(), score.end()) - score.begin());
  // Sensors begin ahead or behind. A row of poles or a hedge can feign another beginning, as it
  // steps back in ring after ring, but hardly a clearer one.
  constexpr double kClearly = 0.7;
  if (near(BinOf(0.0)) > kClearly * score[best]) return 0.0;
  if (near(0) > kClearly * score[best]) return -kPi;
  return Wrapped((static_cast<double>(best) + 0.5) * kBin_rad - kPi);
}

double StoredTurns(const RawScan& scan, float min_range) {
  const std::vector<Direction> directions = Directions(scan, min_range);
  // Means of so many parts: beams of one firing look up to 7 deg to either side.
  constexpr size_t kParts = 90;
  if (directions.size() < 4 * kParts) return 0.0;
  double turns = 0.0, wandered = 0.0, previous_rad = 0.0;
  for (size_t part = 0; part < kParts; ++part) {
    double x = 0.0, y = 0.0;
    const size_t end = (part + 1) * directions.size() / kParts;
    for (size_t i = part * directions.size() / kParts; i < end; ++i) {
      x += std::cos(directions[i].azimuth_rad), y += std::sin(directions[i].azimuth_rad);
    }
    const double mean_rad = std::atan2(y, x);
    const double step = part == 0 ? 0.0 : Wrapped(mean_rad - previous_rad);
    turns += step / (2.0 * kPi), wandered += std::abs(step) / (2.0 * kPi);
    previous_rad = mean_rad;
  }
  return std::abs(turns) > 0.9 * wandered ? turns : 0.0;
}

std::vector<float> TimesFromOrder(const RawScan& scan, const std::vector<uint32_t>& kept,
                                  bool is_clockwise, double sweep_s) {
  std::vector<float> out;
  if (kept.empty()) return out;
  // The azimuth the sweep begins at: half a hundredth before the mean of its first hundredth.
  const double sense = is_clockwise ? -1.0 : 1.0;
  double x = 0.0, y = 0.0;
  for (size_t k = 0; k <= kept.size() / 100; ++k) {
    const Eigen::Vector3f& p = scan.points[kept[k]];
    const double h = static_cast<double>(std::max(p.head<2>().norm(), 1e-6F));
    x += static_cast<double>(p.x()) / h, y += static_cast<double>(p.y()) / h;
  }
  const double start_rad = std::atan2(y, x) - sense * 0.005 * 2.0 * kPi;
  out.reserve(kept.size());
  for (size_t k = 0; k < kept.size(); ++k) {
    const Eigen::Vector3f& p = scan.points[kept[k]];
    const double azimuth_rad = static_cast<double>(FastAtan2(p.y(), p.x()));
    const double share = static_cast<double>(k) / static_cast<double>(kept.size());
    // Beams look a little to either side: which turn it is, the place in the order tells.
    const double ahead = sense * (azimuth_rad - start_rad) / (2.0 * kPi) - share;
    const double phase = share + ahead - std::round(ahead);
    out.push_back(static_cast<float>((phase - 0.5) * sweep_s));
  }
  return out;
}

}  // namespace tvl
