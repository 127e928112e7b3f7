#include "tvl/loop/visual_proposer.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Each round brings in features that the pose before was too far off for; a third adds none.
constexpr int kGuidedRounds = 2;

std::vector<PnpMatch> MatchesOf(const std::vector<FeaturePair>& pairs, const ImageFeatures& history,
                                const ImageFeatures& current) {
  std::vector<PnpMatch> matches;
  for (const FeaturePair& pair : pairs) {
    const auto h = static_cast<size_t>(pair.history), c = static_cast<size_t>(pair.current);
    matches.push_back({history.ray_cam[h].cast<double>(), current.ray_cam[c].cast<double>(),
                       static_cast<double>(history.depth_m[h]),
                       static_cast<double>(current.depth_m[c])});
  }
  return matches;
}

// A pose from few matches, then from all that it leads to.
PnpResult FindPose(const std::vector<FeaturePair>& pairs, const ImageFeatures& history,
                   const ImageFeatures& current, const VisualProposerOptions& options) {
  PnpOptions start = options.pnp;
  start.min_inliers = options.min_start_inliers;
  PnpResult pnp = SolvePnp(MatchesOf(pairs, history, current), start);
  for (int round = 1; round <= kGuidedRounds && pnp.status == PnpStatus::kFound; ++round) {
    const auto guided = MatchGuided(history, current, pnp.T_history_current, options.guided);
    pnp =
        SolvePnp(MatchesOf(guided, history, current), round == kGuidedRounds ? options.pnp : start);
  }
  return pnp;
}

bool IsBetter(const Island& a, const Island& b) {
  return a.score != b.score ? a.score > b.score : a.first < b.first;
}

VisualVerdict VerdictOf(PnpStatus status) {
  switch (status) {
    case PnpStatus::kFound:
      return VisualVerdict::kProposed;
    case PnpStatus::kFewPoints:
      return VisualVerdict::kFewMatches;
    case PnpStatus::kFewInliers:
      return VisualVerdict::kFewInliers;
  }
  throw Error("PnpStatus: unknown value");
}

}  // namespace

const char* ToString(VisualVerdict verdict) {
  switch (verdict) {
    case VisualVerdict::kProposed:
      return "proposed";
    case VisualVerdict::kNotConsistent:
      return "not_consistent";
    case VisualVerdict::kFewMatches:
      return "few_matches";
    case VisualVerdict::kFewInliers:
      return "few_inliers";
  }
  throw Error("VisualVerdict: unknown value");
}

void VisualProposerOptions::Check() const {
  TVL_CHECK_INPUT(direct_level >= 0) << "direct_level: must not be negative, is " << direct_level;
  TVL_CHECK_INPUT(min_relative_similarity > 0.0)
      << "min_relative_similarity: must be positive, is " << min_relative_similarity;
  TVL_CHECK_INPUT(min_reference_similarity > 0.0)
      << "min_reference_similarity: must be positive, is " << min_reference_similarity;
  TVL_CHECK_INPUT(island_gap >= 1) << "island_gap: must be at least 1, is " << island_gap;
  TVL_CHECK_INPUT(min_consistent >= 1)
      << "min_consistent: must be at least 1, is " << min_consistent;
  TVL_CHECK_INPUT(max_islands >= 1) << "max_islands: must be at least 1, is " << max_islands;
  TVL_CHECK_INPUT(min_start_inliers >= 6)
      << "min_start_inliers: must be at least 6, is " << min_start_inliers;
  matching.Check();
  guided.Check();
  pnp.Check();
}

VisualProposer::VisualProposer(std::shared_ptr<const Vocabulary> vocabulary,
                               const Calibration& calibration, const VisualProposerOptions& options)
    : database_(std::move(vocabulary), options.direct_level),
      calibration_(calibration),
      options_(options) {
  options_.Check();
}

std::vector<Island> VisualProposer::FindIslands(int query, const MayMatch& may_match) const {
  std::vector<Island> islands;
  if (query < 1) return islands;
  const double reference = Similarity(database_.bag(query), database_.bag(query - 1));
  if (reference < options_.min_reference_similarity) return islands;
  for (const VisualMatch& match : database_.Query(query, query)) {
    const double similarity = match.similarity / reference;
    if (similarity < options_.min_relative_similarity || !may_match(match.keyframe)) continue;
    if (islands.empty() || match.keyframe > islands.back().last + options_.island_gap) {
      islands.push_back({match.keyframe, match.keyframe, match.keyframe, 0.0, 0.0});
    }
    Island& island = islands.back();
    island.last = match.keyframe;
    island.score += similarity;
    if (similarity > island.similarity) {
      island.similarity = similarity;
      island.best = match.keyframe;
    }
  }
  std::sort(islands.begin(), islands.end(), IsBetter);
  if (islands.size() > static_cast<size_t>(options_.max_islands)) {
    islands.resize(static_cast<size_t>(options_.max_islands));
  }
  return islands;
}

bool VisualProposer::IsConsistent(int current, const Island& island,
                                  const MayMatch& may_match) const {
  const int reach = options_.island_gap;
  for (int back = 1; back < options_.min_consistent; ++back) {
    const std::vector<Island> before = FindIslands(current - back, may_match);
    const bool is_there = std::any_of(before.begin(), before.end(), [&](const Island& other) {
      return other.first <= island.last + reach && other.last >= island.first - reach;
    });
    if (!is_there) return false;
  }
  return true;
}

VisualCandidate VisualProposer::Compare(int current, const Island& island,
                                        const FeatureSource& features) const {
  const std::shared_ptr<const ImageFeatures> of_history = features(island.best);
  const std::shared_ptr<const ImageFeatures> of_current = features(current);
  TVL_CHECK(of_history != nullptr && of_current != nullptr) << "no features of a keyframe";
  const std::vector<FeaturePair> pairs =
      MatchFeatures(*of_history, database_.direct_index(island.best), *of_current,
                    database_.direct_index(current), options_.matching);
  const PnpResult pnp = FindPose(pairs, *of_history, *of_current, options_);
  const Rigid3d& T_cam_lidar = calibration_.T_cam_lidar;
  return {island,
          VerdictOf(pnp.status),
          static_cast<int>(pairs.size()),
          pnp.points,
          pnp.inliers,
          T_cam_lidar.Inverse() * pnp.T_history_current * T_cam_lidar};
}

VisualProposals VisualProposer::Propose(int current, const FeatureSource& features,
                                        const MayMatch& may_match) const {
  VisualProposals result;
  for (const Island& island : FindIslands(current, may_match)) {
    if (!IsConsistent(current, island, may_match)) {
      result.candidates.push_back({island, VisualVerdict::kNotConsistent, 0, 0, 0, {}});
      continue;
    }
    const VisualCandidate candidate = Compare(current, island, features);
    result.candidates.push_back(candidate);
    if (candidate.verdict != VisualVerdict::kProposed) continue;
    result.proposals.push_back({island.best, current, LoopProposer::kVisual, LoopGuess::kPose,
                                candidate.T_history_current, island.similarity, candidate.inliers});
  }
  return result;
}

}  // namespace tvl
