#include "tvl/loop/feature_matching.h"

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/loop/hamming.h"

namespace tvl {
namespace {

// The nearest and second nearest of one feature so far.
struct Nearest {
  int feature = -1;
  int distance = 257, second = 257;

  void Offer(int other, int d) {
    if (d < distance) {
      second = distance;
      distance = d;
      feature = other;
    } else {
      second = std::min(second, d);
    }
  }
  bool IsDistinct(const FeatureMatchingOptions& options) const {
    return feature >= 0 && distance <= options.max_distance_bits &&
           static_cast<double>(distance) < options.max_ratio * static_cast<double>(second);
  }
};

// End of the run of equal nodes that begins at `begin`.
size_t EndOfRun(const std::vector<int32_t>& node, size_t begin) {
  size_t end = begin;
  while (end < node.size() && node[end] == node[begin]) ++end;
  return end;
}

}  // namespace

void FeatureMatchingOptions::Check() const {
  TVL_CHECK_INPUT(max_distance_bits >= 0 && max_distance_bits <= 256)
      << "max_distance_bits: must lie in 0..256, is " << max_distance_bits;
  TVL_CHECK_INPUT(max_ratio > 0.0 && max_ratio <= 1.0)
      << "max_ratio: must lie in 0..1, is " << max_ratio;
}

std::vector<FeaturePair> MatchFeatures(const ImageFeatures& history,
                                       const DirectIndex& history_index,
                                       const ImageFeatures& current,
                                       const DirectIndex& current_index,
                                       const FeatureMatchingOptions& options) {
  std::vector<Nearest> of_history(history.size()), of_current(current.size());
  const auto& nodes_h = history_index.node;
  const auto& nodes_c = current_index.node;
  for (size_t h = 0, c = 0; h < nodes_h.size() && c < nodes_c.size();) {
    const size_t end_h = EndOfRun(nodes_h, h), end_c = EndOfRun(nodes_c, c);
    const bool is_shared = nodes_h[h] == nodes_c[c];
    for (size_t i = h; is_shared && i < end_h; ++i) {
      const uint16_t a = history_index.feature[i];
      for (size_t j = c; j < end_c; ++j) {
        const uint16_t b = current_index.feature[j];
        const int d = HammingDistance(history.descriptors[a], current.descriptors[b]);
        of_history[a].Offer(b, d);
        of_current[b].Offer(a, d);
      }
    }
    const bool advance_h = nodes_h[h] <= nodes_c[c], advance_c = nodes_c[c] <= nodes_h[h];
    if (advance_h) h = end_h;
    if (advance_c) c = end_c;
  }
  std::vector<FeaturePair> pairs;
  for (size_t i = 0; i < of_history.size(); ++i) {
    const Nearest& nearest = of_history[i];
    if (!nearest.IsDistinct(options)) continue;
    const Nearest& back = of_current[static_cast<size_t>(nearest.feature)];
    if (back.feature == static_cast<int>(i) && back.IsDistinct(options)) {
      pairs.push_back({static_cast<int>(i), nearest.feature});
    }
  }
  return pairs;
}

}  // namespace tvl
