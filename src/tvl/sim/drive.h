// A planned drive: where the lidar is at every instant, and the streets it leads through.
#pragma once

#include <utility>
#include <vector>

#include "tvl/sim/ground.h"
#include "tvl/sim/pose_spline.h"
#include "tvl/sim/route.h"
#include "tvl/sim/sim_options.h"
#include "tvl/sim/terrain.h"
#include "tvl/sim/vehicle.h"

namespace tvl::sim {

inline constexpr double kFrameInterval_s = 0.1;  // 10 Hz, as KITTI
inline constexpr double kLidarHeight_m = 1.73;   // above the road, KITTI's car

struct Drive {
  Route route;
  Terrain terrain;
  TravelProfile travel;      // way along route.lane
  PoseSpline T_world_lidar;  // the truth; time 0 is frame 0
  int frames = 0;
  FrameRange night;                               // of the preset or as asked for
  std::vector<std::pair<double, double>> open_m;  // stretches of the lane without a town
  std::vector<std::pair<double, double>> bare_m;  // and with nothing upright at all
  StreetProfile profile;
};

// Plans the drive of a preset or along a pose file. T_cam0_lidar: of the sensors, for pose files.
// Throws InputError for a bad pose file, naming it.
Drive PlanDrive(const SimOptions& options, const Rigid3d& T_cam0_lidar);

}  // namespace tvl::sim
