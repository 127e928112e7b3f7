// Visual loop detection (paper 6.2): which earlier keyframe shows this place, and from where.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tvl/frame/image_features.h"
#include "tvl/loop/feature_matching.h"
#include "tvl/loop/guided_matching.h"
#include "tvl/loop/pnp.h"
#include "tvl/loop/visual_database.h"
#include "tvl/map/loop.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct VisualProposerOptions {
  // Level of the tree below whose nodes features are compared: 1 misses few pairs and compares
  // a tenth of all.
  int direct_level = 1;
  // Similarity to an earlier keyframe over that to the previous one (a metre back): how much of
  // what could be alike is.
  double min_relative_similarity = 0.25;
  // With less in common with the previous keyframe the image is blurred, dark or hidden: no base
  // for comparing.
  double min_reference_similarity = 0.01;
  // Keyframes no farther apart than this are one place (an island), looked at once.
  int island_gap = 3;
  // Temporal consistency: this many keyframes in a row must have an island at the place.
  int min_consistent = 2;
  int max_islands = 3;  // the best are compared feature by feature: 2 ms each
  FeatureMatchingOptions matching;
  // A pose that so many of these matches agree on is worth looking for more (`guided`) before
  // pnp.min_inliers are asked for: 3 m apart on a real street 12 do, and 30 are there. Of a wrong
  // place 4 agree, at the most (7 where the images show part of the same).
  int min_start_inliers = 8;
  GuidedMatchingOptions guided;
  PnpOptions pnp;

  void Check() const;  // throws InputError naming the field
};

// Neighbouring keyframes that look like the one asked for.
struct Island {
  int first = 0, last = 0;  // keyframes, last included
  int best = 0;             // the most alike
  double similarity = 0.0;  // of the best, over the similarity to the previous keyframe
  double score = 0.0;       // sum of all
};

// What became of one island.
enum class VisualVerdict {
  kProposed,
  kNotConsistent,  // the keyframes before did not see it
  kFewMatches,     // too few features correspond, or too few of them have a depth
  kFewInliers,     // no pose explains enough of them
};
const char* ToString(VisualVerdict verdict);

struct VisualCandidate {
  Island island;
  VisualVerdict verdict = VisualVerdict::kProposed;
  // Pairs by descriptor; of those the last pose was sought with (guided, if it came so far) the
  // ones with depth, and of these the ones that agree.
  int matches = 0, points = 0, inliers = 0;
  Rigid3d T_history_current;  // lidar frames; valid for kProposed
};

struct VisualProposals {
  std::vector<LoopProposal> proposals;      // at most one an island
  std::vector<VisualCandidate> candidates;  // all islands looked at, the best first
};

// Not thread-safe while keyframes are added. Answers depend on the keyframes added and the
// arguments only, not on what was asked before.
class VisualProposer {
 public:
  // Fetches the features of a keyframe, which may lie on disk. Must not return null.
  using FeatureSource = std::function<std::shared_ptr<const ImageFeatures>(int keyframe)>;
  // True for keyframes that may show the place of the current one: far enough back in time and
  // path (t_th), and near enough by the estimated poses (geometric consistency, R1).
  using MayMatch = std::function<bool(int history)>;

  // Throws InputError for unusable options.
  VisualProposer(std::shared_ptr<const Vocabulary> vocabulary, const Calibration& calibration,
                 const VisualProposerOptions& options = {});

  // The next keyframe; the first is 0. Without features (no image, darkness) it is never proposed.
  void Add(const ImageFeatures& features) { database_.Add(features.descriptors); }

  // Loops of an added keyframe with earlier ones.
  VisualProposals Propose(int current, const FeatureSource& features,
                          const MayMatch& may_match) const;

  // Where keyframe `query` seems to have been before, the best first.
  std::vector<Island> FindIslands(int query, const MayMatch& may_match) const;

  const VisualDatabase& database() const { return database_; }

 private:
  bool IsConsistent(int current, const Island& island, const MayMatch& may_match) const;
  VisualCandidate Compare(int current, const Island& island, const FeatureSource& features) const;

  VisualDatabase database_;
  Calibration calibration_;
  VisualProposerOptions options_;
};

}  // namespace tvl
