#include "tvl/eval/path_length.h"

#include <algorithm>

namespace tvl {

std::vector<double> PathLengths(const std::vector<Rigid3d>& poses) {
  std::vector<double> lengths_m(poses.size(), 0.0);
  for (size_t i = 1; i < poses.size(); ++i) {
    lengths_m[i] = lengths_m[i - 1] + (poses[i].t() - poses[i - 1].t()).norm();
  }
  return lengths_m;
}

std::optional<size_t> IndexAfter(const std::vector<double>& lengths_m, size_t first,
                                 double distance_m) {
  const auto begin = lengths_m.begin() + static_cast<std::ptrdiff_t>(first);
  const auto found = std::upper_bound(begin, lengths_m.end(), lengths_m[first] + distance_m);
  if (found == lengths_m.end()) return std::nullopt;
  return static_cast<size_t>(found - lengths_m.begin());
}

}  // namespace tvl
