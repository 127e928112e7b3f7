// More pairs of corresponding features once a pose is known roughly (paper 6.2 stops at PnP).
//
// Between images taken 3 m apart on a real street, matching by descriptors alone finds a dozen true
// pairs: corners look different, neighbours alike, and the ratio test drops what it cannot decide.
// With a pose from that dozen, a corner is looked for where it must be, among one or two.
#pragma once

#include <vector>

#include "tvl/frame/image_features.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/loop/feature_matching.h"

namespace tvl {

struct GuidedMatchingOptions {
  // Angle between where a feature must be and where it is: the error of a pose found from eight
  // points, at points 10 m away.
  double max_error_rad = 0.007;
  // Of 256 bits. Looser than without a pose: hardly ever is there another corner to choose from.
  int max_distance_bits = 80;

  void Check() const;  // throws InputError naming the field
};

// Pairs that are each other's nearest descriptor among those where the pose puts them, by
// `history`. Features without depth on either side are in none. T_history_current: camera frames.
std::vector<FeaturePair> MatchGuided(const ImageFeatures& history, const ImageFeatures& current,
                                     const Rigid3d& T_history_current,
                                     const GuidedMatchingOptions& options);

}  // namespace tvl
