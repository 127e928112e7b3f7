#include "tvl/io/pairing.h"

#include <algorithm>
#include <cmath>

namespace tvl {
namespace {

double Distance_s(Timestamp a, Timestamp b) { return std::abs(SecondsBetween(a, b)); }

size_t Nearest(const std::vector<Timestamp>& images, Timestamp instant) {
  const auto after = std::lower_bound(images.begin(), images.end(), instant);
  if (after == images.begin()) return 0;
  const size_t i = static_cast<size_t>(after - images.begin());
  if (after == images.end()) return i - 1;
  return Distance_s(images[i - 1], instant) <= Distance_s(images[i], instant) ? i - 1 : i;
}

}  // namespace

std::vector<std::optional<size_t>> PairImages(const std::vector<Timestamp>& instants,
                                              const std::vector<Timestamp>& images,
                                              double within_s) {
  std::vector<std::optional<size_t>> pairs(instants.size());
  std::vector<std::optional<size_t>> scan_of(images.size());
  if (images.empty()) return pairs;
  for (size_t k = 0; k < instants.size(); ++k) {
    const size_t i = Nearest(images, instants[k]);
    const double distance_s = Distance_s(images[i], instants[k]);
    if (distance_s > within_s) continue;
    if (scan_of[i]) {
      if (Distance_s(images[i], instants[*scan_of[i]]) <= distance_s) continue;
      pairs[*scan_of[i]].reset();
    }
    scan_of[i] = k;
    pairs[k] = i;
  }
  return pairs;
}

double MedianPeriod_s(const std::vector<Timestamp>& stamps, double otherwise_s) {
  std::vector<double> periods_s;
  for (size_t i = 1; i < stamps.size(); ++i) {
    periods_s.push_back(SecondsBetween(stamps[i - 1], stamps[i]));
  }
  if (periods_s.empty()) return otherwise_s;
  const auto middle = periods_s.begin() + static_cast<std::ptrdiff_t>(periods_s.size() / 2);
  std::nth_element(periods_s.begin(), middle, periods_s.end());
  return *middle > 0.0 ? *middle : otherwise_s;
}

}  // namespace tvl
