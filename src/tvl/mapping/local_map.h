// The surrounding map (paper Eq. 9-11): the keyframes the current scan is registered against.
//
// A keyframe is in it while it is recent by path, or because an accepted loop says that it is near.
// Distance alone (Eq. 10 as printed) would fetch the old pass of a drifted revisit. Everything is
// in the odometry frame, which never jumps: a loop moves old keyframes to where the current ones
// are, not the other way round. Keyframe clouds are the truth, the surfels a cache of them.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "tvl/map/keyframe.h"
#include "tvl/registration/surfel_map.h"

namespace tvl {

struct LocalMapOptions {
  double keep_path_m = 100.0;  // path behind the newest keyframe
  // Keyframes of an earlier pass are fetched within this distance (Eq. 10), once a loop links them.
  double connected_radius_m = 50.0;
  // Of them, added or taken away with each new keyframe: more would make its frame late.
  int connected_changes = 3;
  // A connected keyframe is placed anew when the graph has moved it by this much against the
  // current one: half a wall's thickness as surfels see it.
  double connected_tolerance_m = 0.03;
  SurfelMapOptions planes{SurfelKind::kPlane, {0.5, 1.0, 2.0}, {}};
  // Edge points are few; a pole is thinner than a wall is flat.
  SurfelMapOptions lines{SurfelKind::kLine, {1.0}, {5, 0.12, 3.0, 0.12}};
  void Check() const;
};

// A keyframe as it takes part: where, and what it saw.
struct LocalMapMember {
  int keyframe = 0;
  double path_m = 0.0;
  Rigid3d T_odom_lidar;
  std::shared_ptr<const KeyframeCloud> cloud;
};

class LocalMap {
 public:
  explicit LocalMap(const LocalMapOptions& options);

  // Adds a keyframe and lets go of those the path has left behind.
  void Add(const LocalMapMember& member, const Executor& executor);

  // A keyframe of an earlier pass and where the graph now has it.
  struct Connected {
    int keyframe = 0;
    Rigid3d T_odom_lidar;
  };
  using FetchCloud = std::function<std::shared_ptr<const KeyframeCloud>(int keyframe)>;
  // Brings the connected members closer to `wanted` (most wanted first), by connected_changes at
  // most: what is no longer wanted goes and what has moved is placed anew, then new ones come.
  // Keyframes that are recent by path are not taken twice.
  void Connect(const std::vector<Connected>& wanted, const FetchCloud& fetch,
               const Executor& executor);

  bool empty() const { return members_.empty(); }
  size_t size() const { return members_.size() + connected_.size(); }
  size_t connected() const { return connected_.size(); }
  const SurfelMap& planes() const { return planes_; }
  const SurfelMap& lines() const { return lines_; }

 private:
  void Put(const LocalMapMember& member, const Executor& executor);
  void Take(const LocalMapMember& member, const Executor& executor);
  bool IsRecent(int keyframe) const;

  // Poses are those the clouds were added with: removal must undo it exactly.
  std::deque<LocalMapMember> members_;
  std::map<int, LocalMapMember> connected_;
  LocalMapOptions options_;
  SurfelMap planes_, lines_;
};

}  // namespace tvl
