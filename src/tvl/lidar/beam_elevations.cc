#include "tvl/lidar/beam_elevations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

double Median(std::vector<float>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return static_cast<double>(*middle);
}

struct RangedElevation {
  float range, elevation_rad;
};

// Of the farther half.
LineElevation Summarise(std::vector<RangedElevation> points) {
  LineElevation line;
  line.points = points.size();
  if (points.empty()) return line;
  const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
  std::nth_element(
      points.begin(), middle, points.end(),
      [](const RangedElevation& a, const RangedElevation& b) { return a.range < b.range; });
  std::vector<float> values;
  for (auto i = middle; i != points.end(); ++i) values.push_back(i->range);
  line.range = Median(&values);
  values.clear();
  for (auto i = middle; i != points.end(); ++i) values.push_back(i->elevation_rad);
  line.median_rad = Median(&values);
  for (float& value : values) value = std::abs(value - static_cast<float>(line.median_rad));
  line.scatter_rad = Median(&values);
  return line;
}

// Histogram of elevations in bins of kBin_rad from straight down.
constexpr double kBin_rad = 0.01 * kPi / 180.0;
constexpr int kBins = 18000;

// Box filter of 2 * half + 1 bins.
std::vector<double> Smooth(const std::vector<double>& counts, int half) {
  std::vector<double> sums(counts.size() + 1, 0.0), out(counts.size(), 0.0);
  for (size_t i = 0; i < counts.size(); ++i) sums[i + 1] = sums[i] + counts[i];
  for (int i = 0; i < static_cast<int>(counts.size()); ++i) {
    const int begin = std::max(i - half, 0);
    const int end = std::min(i + half + 1, static_cast<int>(counts.size()));
    out[static_cast<size_t>(i)] = sums[static_cast<size_t>(end)] - sums[static_cast<size_t>(begin)];
  }
  return out;
}

struct Peak {
  int begin = 0, end = 0;  // bins
  double points = 0.0, moment = 0.0;
  double Centre() const { return moment / points; }
};

// Runs of bins above `floor`.
std::vector<Peak> FindPeaks(const std::vector<double>& counts, const std::vector<double>& smooth,
                            double floor) {
  std::vector<Peak> peaks;
  bool inside = false;
  for (int i = 0; i < kBins; ++i) {
    const size_t at = static_cast<size_t>(i);
    const bool above = smooth[at] > floor;
    if (above && !inside) peaks.push_back({i, i, 0.0, 0.0});
    inside = above;
    if (!above) continue;
    peaks.back().end = i + 1;
    peaks.back().points += counts[at];
    peaks.back().moment += counts[at] * (i + 0.5);
  }
  return peaks;
}

// Peaks that are narrower than the space between them, as beams are; else none.
std::vector<double> AsBeams(std::vector<Peak> peaks, double all_points) {
  constexpr double kLeast = 0.002;  // share of the points: fewer are no beam
  peaks.erase(std::remove_if(peaks.begin(), peaks.end(),
                             [&](const Peak& p) { return p.points < kLeast * all_points; }),
              peaks.end());
  constexpr size_t kFewestBeams = 4, kMostBeams = 256;
  if (peaks.size() < kFewestBeams || peaks.size() > kMostBeams) return {};
  double within = 0.0, width = 0.0;
  for (const Peak& peak : peaks) within += peak.points, width += peak.end - peak.begin;
  const double span = peaks.back().end - peaks.front().begin;
  // Nearly all points lie in the peaks, and the peaks cover no more than half of what they span.
  if (within < 0.97 * all_points || width > 0.5 * span) return {};
  std::vector<double> beams_rad;
  for (auto peak = peaks.rbegin(); peak != peaks.rend(); ++peak) {
    beams_rad.push_back(peak->Centre() * kBin_rad - 0.5 * kPi);
  }
  return beams_rad;
}

}  // namespace

float Elevation_rad(const Eigen::Vector3f& p) { return std::atan2(p.z(), p.head<2>().norm()); }

bool IsReturn(const Eigen::Vector3f& p, float min_range) {
  const float sq = p.squaredNorm();  // NaN fails both comparisons
  return sq >= min_range * min_range && sq < std::numeric_limits<float>::infinity();
}

std::vector<LineElevation> MeasureLines(const std::vector<const RawScan*>& scans,
                                        const std::vector<std::vector<int>>& line_of, int lines) {
  TVL_CHECK(scans.size() == line_of.size());
  std::vector<std::vector<RangedElevation>> points(static_cast<size_t>(lines));
  for (size_t s = 0; s < scans.size(); ++s) {
    for (size_t i = 0; i < scans[s]->size(); ++i) {
      if (line_of[s][i] < 0) continue;
      const Eigen::Vector3f& p = scans[s]->points[i];
      points[static_cast<size_t>(line_of[s][i])].push_back({p.norm(), Elevation_rad(p)});
    }
  }
  std::vector<LineElevation> out;
  for (std::vector<RangedElevation>& line : points) out.push_back(Summarise(std::move(line)));
  return out;
}

std::vector<double> FindElevationClusters(const std::vector<const RawScan*>& scans,
                                          float min_range) {
  std::vector<double> counts(kBins, 0.0);
  double all = 0.0;
  for (const RawScan* scan : scans) {
    for (const Eigen::Vector3f& p : scan->points) {
      if (!IsReturn(p, min_range)) continue;
      const double bin = (static_cast<double>(Elevation_rad(p)) + 0.5 * kPi) / kBin_rad;
      counts[static_cast<size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += 1.0;
      all += 1.0;
    }
  }
  if (all == 0.0) return {};
  // Beams lie 0.1 to 3 deg apart and their points within a few hundredths of a degree, unless they
  // have been moved. The narrowest smoothing is taken whose answer the next one bears out: less
  // would tear beams apart.
  std::vector<double> previous;
  for (const int half : {1, 2, 4, 8, 16}) {
    const std::vector<double> smooth = Smooth(counts, half);
    const double highest = *std::max_element(smooth.begin(), smooth.end());
    std::vector<double> beams_rad = AsBeams(FindPeaks(counts, smooth, 0.005 * highest), all);
    if (!beams_rad.empty() && beams_rad.size() == previous.size()) return previous;
    previous = std::move(beams_rad);
  }
  return {};
}

}  // namespace tvl
