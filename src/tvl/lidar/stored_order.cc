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

// Middle of the largest range of azimuth without points; -1 if there is none to speak of.
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

}  // namespace

RingBreak FindRingBreak(const RawScan& scan, float min_range) {
  const std::vector<Direction> directions = Directions(scan, min_range);
  RingBreak best;
  if (directions.size() < 2) return best;
  const int gap = LargestGap(directions);
  std::array<double, kAzimuthBins> rise{};
  double lowest = directions[0].elevation_rad, highest = lowest;
  for (size_t i = 1; i < directions.size(); ++i) {
    const Direction& a = directions[i - 1];
    const Direction& b = directions[i];
    const double step = Wrapped(b.azimuth_rad - a.azimuth_rad);
    // A sensor that does not see all round passes from one ring to the next across what it does
    // not see.
    const bool jumps = gap >= 0 && std::abs(step) > kSmallestGap * kBin_rad;
    const int bin = jumps ? gap : BinOf(Wrapped(a.azimuth_rad + 0.5 * step));
    rise[static_cast<size_t>(bin)] += b.elevation_rad - a.elevation_rad;
    lowest = std::min(lowest, b.elevation_rad), highest = std::max(highest, b.elevation_rad);
  }
  const auto sum_around = [&](int i) {  // rings begin within a bin or two of each other
    double sum = 0.0;
    for (int k = -2; k <= 2; ++k) {
      sum += rise[static_cast<size_t>((i + k + kAzimuthBins) % kAzimuthBins)];
    }
    return sum;
  };
  int at = 0;
  for (int i = 1; i < kAzimuthBins; ++i) {
    if (std::abs(sum_around(i)) > std::abs(sum_around(at))) at = i;
  }
  double elsewhere = 0.0;
  for (int i = 5; i <= kAzimuthBins - 5; ++i) {
    elsewhere = std::max(elsewhere, std::abs(sum_around((at + i) % kAzimuthBins)));
  }
  if (highest <= lowest) return best;
  best.azimuth_rad = Wrapped((at + 0.5) * kBin_rad - kPi);
  best.lowest_first = sum_around(at) > 0.0;
  best.share = std::abs(sum_around(at)) / (highest - lowest);
  best.share_elsewhere = elsewhere / (highest - lowest);
  return best;
}

double StoredTurns(const RawScan& scan, float min_range) {
  const std::vector<Direction> directions = Directions(scan, min_range);
  // Means of so many chunks: beams of one firing look up to 7 deg to either side.
  constexpr size_t kChunks = 90;
  if (directions.size() < 4 * kChunks) return 0.0;
  double turns = 0.0, wandered = 0.0, previous_rad = 0.0;
  for (size_t chunk = 0; chunk < kChunks; ++chunk) {
    double x = 0.0, y = 0.0;
    const size_t end = (chunk + 1) * directions.size() / kChunks;
    for (size_t i = chunk * directions.size() / kChunks; i < end; ++i) {
      x += std::cos(directions[i].azimuth_rad), y += std::sin(directions[i].azimuth_rad);
    }
    const double mean_rad = std::atan2(y, x);
    const double step = chunk == 0 ? 0.0 : Wrapped(mean_rad - previous_rad);
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
