// The surrounding map (paper Eq. 9-11): the keyframes the current scan is registered against.
//
// A keyframe is in it while it is recent by path. Distance alone (Eq. 10 as printed) would fetch
// the old pass of a drifted revisit. Keyframe clouds are the truth, the surfels a cache of them.
#pragma once

#include <deque>

#include "tvl/map/keyframe.h"
#include "tvl/registration/surfel_map.h"

namespace tvl {

struct LocalMapOptions {
  double keep_path_m = 100.0;  // path behind the newest keyframe
  SurfelMapOptions planes{SurfelKind::kPlane, {0.5, 1.0, 2.0}, {}};
  // Edge points are few; a pole is thinner than a wall is flat.
  SurfelMapOptions lines{SurfelKind::kLine, {1.0}, {5, 0.12, 3.0, 0.12}};
  void Check() const;
};

class LocalMap {
 public:
  explicit LocalMap(const LocalMapOptions& options);

  // Adds a keyframe and lets go of those the path has left behind.
  void Add(const Keyframe& keyframe, const Executor& executor);

  bool empty() const { return members_.empty(); }
  size_t size() const { return members_.size(); }
  const SurfelMap& planes() const { return planes_; }
  const SurfelMap& lines() const { return lines_; }

 private:
  // The pose is the one the clouds were added with: removal must undo it exactly.
  std::deque<Keyframe> members_;
  LocalMapOptions options_;
  SurfelMap planes_, lines_;
};

}  // namespace tvl
