// Poses over time.
#pragma once

#include <vector>

#include "tvl/base/ids.h"
#include "tvl/base/time.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct StampedPose {
  FrameId frame = 0;
  Timestamp stamp;
  Rigid3d T_world_lidar;
};

using Trajectory = std::vector<StampedPose>;

}  // namespace tvl
