#include "tvl/loop/guided_matching.h"

#include "tvl/base/check.h"
#include "tvl/factors/reprojection.h"
#include "tvl/loop/hamming.h"

namespace tvl {
namespace {

struct Nearest {
  int feature = -1;
  int distance = 257;

  void Offer(int other, int d) {
    if (d >= distance) return;
    distance = d;
    feature = other;
  }
};

// Offers each feature of `from` with depth those of `to` near its projection, and the reverse.
void OfferProjected(const ImageFeatures& from, const ImageFeatures& to, const Rigid3d& T_to_from,
                    const GuidedMatchingOptions& options, std::vector<Nearest>* of_from,
                    std::vector<Nearest>* of_to) {
  const auto bound_sq = static_cast<float>(options.max_error_rad * options.max_error_rad);
  for (size_t i = 0; i < from.size(); ++i) {
    if (!(from.depth_m[i] > 0.0f)) continue;
    const Eigen::Vector3d p_from = (from.depth_m[i] * from.ray_cam[i].homogeneous()).cast<double>();
    const Eigen::Vector3d p_to = T_to_from * p_from;
    if (p_to.z() < kMinProjectionDepth_m) continue;
    const Eigen::Vector2f ray = (p_to.head<2>() / p_to.z()).cast<float>();
    for (size_t j = 0; j < to.size(); ++j) {
      if ((to.ray_cam[j] - ray).squaredNorm() > bound_sq) continue;
      const int d = HammingDistance(from.descriptors[i], to.descriptors[j]);
      if (d > options.max_distance_bits) continue;
      (*of_from)[i].Offer(static_cast<int>(j), d);
      (*of_to)[j].Offer(static_cast<int>(i), d);
    }
  }
}

}  // namespace

void GuidedMatchingOptions::Check() const {
  TVL_CHECK_INPUT(max_error_rad > 0.0) << "max_error_rad: must be positive, is " << max_error_rad;
  TVL_CHECK_INPUT(max_distance_bits >= 0 && max_distance_bits <= 256)
      << "max_distance_bits: must lie in 0..256, is " << max_distance_bits;
}

std::vector<FeaturePair> MatchGuided(const ImageFeatures& history, const ImageFeatures& current,
                                     const Rigid3d& T_history_current,
                                     const GuidedMatchingOptions& options) {
  std::vector<Nearest> of_history(history.size()), of_current(current.size());
  OfferProjected(history, current, T_history_current.Inverse(), options, &of_history, &of_current);
  OfferProjected(current, history, T_history_current, options, &of_current, &of_history);
  std::vector<FeaturePair> pairs;
  for (size_t i = 0; i < of_history.size(); ++i) {
    const int other = of_history[i].feature;
    if (other < 0 || of_current[static_cast<size_t>(other)].feature != static_cast<int>(i)) {
      continue;
    }
    pairs.push_back({static_cast<int>(i), other});
  }
  return pairs;
}

}  // namespace tvl
