// Pairs of corresponding features in two images, through the direct index (paper 6.2).
#pragma once

#include <vector>

#include "tvl/frame/image_features.h"
#include "tvl/loop/visual_database.h"

namespace tvl {

struct FeatureMatchingOptions {
  // Of 256 bits. The same corner a metre further on differs by 20 to 60, strangers by 128 +- 20.
  int max_distance_bits = 72;
  // The best distance over the second best: above, the pattern repeats (railings, windows).
  double max_ratio = 0.85;

  void Check() const;  // throws InputError naming the field
};

struct FeaturePair {
  int history = 0, current = 0;  // features of the two images
};

// Pairs that are each other's best within a node of the direct index, by `history`. A feature is in
// at most one pair.
std::vector<FeaturePair> MatchFeatures(const ImageFeatures& history,
                                       const DirectIndex& history_index,
                                       const ImageFeatures& current,
                                       const DirectIndex& current_index,
                                       const FeatureMatchingOptions& options);

}  // namespace tvl
