// Places that change between passes: parked cars and bins come, go and make room for others, the
// foliage of trees and bushes moves. What somebody could see does not change.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tvl/sim/pose_spline.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/scene.h"

namespace tvl::sim {

struct ChangeOptions {
  uint64_t seed = 1;
  // Of the things that can change, this many do between two passes: half of the parked cars and
  // bins that were there are gone, the others are replaced; plants are turned, leaves and all.
  double share = 0.0;
  // Seen is what lies in line of sight, the houses being opaque, and no farther away than this:
  // more than the lidar's 80 m.
  double sight_m = 120.0;
  // A thing is passed while it is seen this near, and passed again after at least this time...
  double pass_m = 50.0;
  double pass_gap_s = 15.0;
  double hidden_s = 3.0;  // ...during which it must be out of sight this long to change
};

// The way the sensors take.
struct SensorPath {
  PoseSpline T_world_lidar;
  double end_s;  // from 0
};

// What stands in a place from begin_s until end_s.
struct Stay {
  double begin_s, end_s;
  SceneInstance thing;
};

// Things that are there for a time, on top of other movers. Const and thread-safe.
class ChangingThings : public MoverSource {
 public:
  // `others` may be null.
  ChangingThings(std::vector<Stay> stays, PoseSpline T_world_lidar,
                 std::shared_ptr<const MoverSource> others);

  // A thing is there during the whole span if it is in its middle; those more than 250 m from the
  // lidar are left out, where they would be some pixels.
  std::vector<SceneMover> Movers(double begin_s, double end_s) const override;

  const std::vector<Stay>& stays() const { return stays_; }

 private:
  std::vector<Stay> stays_;
  PoseSpline T_world_lidar_;
  std::shared_ptr<const MoverSource> others_;
};

// The town with a share of its things turned into ChangingThings (around description.movers).
// Every change happens in the middle of the longest time between two passes at which the place is
// out of sight, judged every 0.3 s from the lidar's position. What stands in for a thing needs no
// more room than was kept free for that. A share of 0 returns the description as it is. The changes
// at a smaller share are among those at a larger one.
SceneDescription WithChanges(SceneDescription description, const Prototypes& prototypes,
                             const SensorPath& path, const ChangeOptions& options);

}  // namespace tvl::sim
