#include "tvl/sim/preset_scene.h"

#include <memory>
#include <utility>

#include "tvl/sim/changes.h"
#include "tvl/sim/lane_presets.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/town.h"
#include "tvl/sim/traffic.h"

namespace tvl::sim {
namespace {

TownOptions TownFor(const SimOptions& options, const Drive& drive) {
  TownOptions town;
  town.seed = options.seed;
  town.is_open = options.preset == "open";
  town.is_repeating = options.preset == "aliasing";
  town.open_m = drive.open_m, town.bare_m = drive.bare_m;
  town.profile = drive.profile;
  const bool has_lanes = options.preset == "jam" || options.preset == "passing";
  if (has_lanes) {  // as much farther away as the road is wider
    town.setback_m = drive.profile.half_road_m - StreetProfile().half_road_m;
    town.has_parked_cars = false;
  }
  if (options.preset == "highway") {
    town.setback_m = 6.0;
    town.has_parked_cars = town.has_street_ends = false;
  }
  return town;
}

TrafficOptions TrafficFor(const SimOptions& options) {
  TrafficOptions traffic;
  traffic.seed = options.seed;
  if (options.preset == "traffic") {
    traffic.oncoming_every_s = 3.0;
    traffic.leaders = 3, traffic.followers = 2, traffic.leader_gap_s = 4.0;
    traffic.pedestrian_every_m = 6.0;
  }
  if (options.preset == "open") traffic.pedestrian_every_m = 0.0;
  // A tunnel of one lane; a deserted street.
  if (options.preset == "tunnel" || options.preset == "aliasing" || !options.tunnel.IsEmpty()) {
    traffic.oncoming_every_s = 0.0, traffic.pedestrian_every_m = 0.0;
    traffic.leaders = traffic.followers = 0;
  }
  return traffic;
}

std::shared_ptr<const MoverSource> MoversFor(const SimOptions& options, const Drive& drive,
                                             const Prototypes& prototypes) {
  const double duration_s = drive.frames * kFrameInterval_s;
  const LanePoses poses(drive.route, drive.terrain, drive.profile);
  if (options.preset == "jam") {
    return std::make_shared<LaneTraffic>(
        JamTraffic(poses, drive.travel, prototypes, duration_s, options.seed));
  }
  if (options.preset == "passing") {
    return std::make_shared<LaneTraffic>(
        PassingTraffic(poses, drive.travel, prototypes, duration_s));
  }
  if (options.preset == "highway") {
    return std::make_shared<LaneTraffic>(HighwayTraffic(poses, drive.travel, prototypes, duration_s,
                                                        HighwaySpeed_m_s(options), options.seed));
  }
  return std::make_shared<Traffic>(drive.route, drive.terrain, drive.travel, prototypes, duration_s,
                                   TrafficFor(options));
}

}  // namespace

SceneDescription DescribeScene(const SimOptions& options, const Drive& drive) {
  const Prototypes prototypes = BuildPrototypes(options.seed);
  SceneDescription description =
      BuildTown(drive.route, drive.terrain, prototypes, TownFor(options, drive));
  description.movers = MoversFor(options, drive, prototypes);
  ChangeOptions changes;
  changes.seed = options.seed, changes.share = options.changes;
  return WithChanges(std::move(description), prototypes,
                     {drive.T_world_lidar, drive.frames * kFrameInterval_s}, changes);
}

}  // namespace tvl::sim
