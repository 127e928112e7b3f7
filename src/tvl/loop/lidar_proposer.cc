#include "tvl/loop/lidar_proposer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/loop/lidar_descriptor_match.h"

namespace tvl {
namespace {

LoopProposal ToProposal(int history, int current, const PlaceMatch& match, double max_ambiguity) {
  LoopProposal proposal;
  proposal.history = history;
  proposal.current = current;
  proposal.proposer = LoopProposer::kLidar;
  proposal.guess = match.ambiguity < max_ambiguity ? LoopGuess::kPose : LoopGuess::kYaw;
  proposal.T_history_current =
      Rigid3d(ExpSo3({0.0, 0.0, match.yaw_rad}), Eigen::Vector3d(match.x_m, match.y_m, 0.0));
  proposal.score = match.similarity;
  return proposal;
}

}  // namespace

void LidarProposerOptions::Check() const {
  TVL_CHECK_INPUT(shortlist >= 1) << "shortlist must be at least 1: " << shortlist;
  TVL_CHECK_INPUT(shortlist_gap >= 1) << "shortlist_gap must be at least 1: " << shortlist_gap;
  TVL_CHECK_INPUT(max_offset_m > 0.0) << "max_offset_m must be positive: " << max_offset_m;
  TVL_CHECK_INPUT(min_similarity >= 0.0 && min_similarity <= 1.0)
      << "min_similarity must be between 0 and 1: " << min_similarity;
  TVL_CHECK_INPUT(max_ambiguity >= 0.0 && max_ambiguity <= 1.0)
      << "max_ambiguity must be between 0 and 1: " << max_ambiguity;
  TVL_CHECK_INPUT(max_proposals >= 1) << "max_proposals must be at least 1: " << max_proposals;
}

LidarProposer::LidarProposer(const LidarDescriptorOptions& descriptor,
                             const LidarProposerOptions& options)
    : descriptor_options_(descriptor), options_(options) {
  descriptor_options_.Check();
  options_.Check();
}

void LidarProposer::Add(LidarDescriptor descriptor) {
  descriptors_.push_back(std::move(descriptor));
}

const LidarDescriptor& LidarProposer::descriptor(int keyframe) const {
  TVL_CHECK(keyframe >= 0 && keyframe < size()) << "keyframe " << keyframe << " of " << size();
  return descriptors_[static_cast<size_t>(keyframe)];
}

std::vector<int> LidarProposer::Shortlist(const KeyframeTrack& track, int current, int eligible,
                                          const std::vector<double>& linked_path_m,
                                          const DriftRadius& radius) const {
  const LidarDescriptor& place = descriptor(current);
  const Eigen::Vector3d& here = track.T_world_lidar[static_cast<size_t>(current)].t();
  std::vector<std::pair<float, int>> ranked;  // minus similarity, keyframe
  for (int k = 0; k < eligible; ++k) {
    const size_t i = static_cast<size_t>(k);
    if (descriptors_[i].cells.empty()) continue;
    const double distance_m = (track.T_world_lidar[i].t() - here).norm();
    if (distance_m > radius.Of(linked_path_m[i])) continue;
    ranked.emplace_back(-SignatureSimilarity(descriptors_[i], place), k);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> shortlist;
  for (const auto& [score, k] : ranked) {
    const bool is_near = std::any_of(shortlist.begin(), shortlist.end(), [&, k = k](int other) {
      return std::abs(other - k) < options_.shortlist_gap;
    });
    if (is_near) continue;
    shortlist.push_back(k);
    if (static_cast<int>(shortlist.size()) == options_.shortlist) break;
  }
  return shortlist;
}

std::vector<LoopProposal> LidarProposer::Propose(const KeyframeTrack& track, int current,
                                                 const std::vector<double>& linked_path_m,
                                                 const DriftRadius& radius,
                                                 const LoopSeparationOptions& separation) const {
  const LidarDescriptor& place = descriptor(current);
  const int eligible = EligibleHistory(track, current, separation);
  TVL_CHECK(linked_path_m.size() >= static_cast<size_t>(eligible))
      << linked_path_m.size() << " linked paths for " << eligible << " keyframes";
  if (place.cells.empty() || eligible == 0) return {};
  const std::vector<int> shortlist = Shortlist(track, current, eligible, linked_path_m, radius);
  if (shortlist.empty()) return {};
  const PlaceMatcher matcher(place, options_.max_offset_m, descriptor_options_);
  std::vector<LoopProposal> ranked;
  for (const int k : shortlist) {
    const PlaceMatch match = matcher.Match(descriptors_[static_cast<size_t>(k)]);
    if (match.similarity < options_.min_similarity) continue;
    ranked.push_back(ToProposal(k, current, match, options_.max_ambiguity));
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const LoopProposal& a, const LoopProposal& b) { return a.score > b.score; });
  std::vector<LoopProposal> proposals;
  const auto same_pass = [&](const LoopProposal& a, const LoopProposal& b) {
    return std::abs(track.path_m[static_cast<size_t>(a.history)] -
                    track.path_m[static_cast<size_t>(b.history)]) <= separation.pass_gap_m;
  };
  for (const LoopProposal& candidate : ranked) {
    const bool is_known =
        std::any_of(proposals.begin(), proposals.end(),
                    [&](const LoopProposal& p) { return same_pass(p, candidate); });
    if (!is_known) proposals.push_back(candidate);
    if (static_cast<int>(proposals.size()) == options_.max_proposals) break;
  }
  return proposals;
}

}  // namespace tvl
