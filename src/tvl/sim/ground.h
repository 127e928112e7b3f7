// The ground of the town: roads with a camber, kerbs, pavements and what lies behind them.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sim/mesh.h"
#include "tvl/sim/polyline.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

// Cross-section of a street, by distance from its axis. Where streets meet, the nearest axis
// counts, so that crossings open by themselves.
struct StreetProfile {
  double half_road_m = 5.4;      // two lanes of 1.7 + parking: kerb to kerb 10.8 m
  double kerb_height_m = 0.12;   // usual
  double kerb_width_m = 0.15;    // usual
  double pavement_end_m = 7.6;   // 2 m of slabs
  double camber = 0.0025;        // height = -camber * d^2, 1/m
  double pavement_slope = 0.02;  // falls to the road
  double bumps = 1.0;            // of the ground behind it: 1 as beside a street, 0.06 m
  double fine_reach_m = 36.0;    // as far as things stand beside a street
  Material road = Material::kAsphalt, kerb = Material::kKerb;
  // Dashed lines: how far left of the axis, and how long at which distance.
  std::vector<double> lines_m = {0.0};
  double dash_m = 3.0, dash_period_m = 9.0;
};

// One-way road of four lanes of kLaneWidth_m; the driven lane is the second from the right.
inline constexpr double kLaneWidth_m = 3.5;
StreetProfile FourLanes();

// A road out of towns: verges without kerbs, mown and even. What it is paved with decides how much
// there is to see on it: rich has repairs, cracks and lines; poor is smooth, with few lane marks
// only; wet is dark, and the lidar loses most of its returns beyond 20 m.
enum class RoadSurface { kRich, kPoor, kWet };
StreetProfile Highway(RoadSurface surface);

// Height of the surface over the terrain at a distance from the nearest axis, m.
double ProfileHeight(const StreetProfile& profile, double distance_m);

// The ground around `axes`, world frame.
Mesh BuildGround(const std::vector<Polyline>& axes, const Terrain& terrain,
                 const StreetProfile& profile);

// The dashed lines along the axes, world frame.
Mesh BuildMarkings(const std::vector<Polyline>& axes, const Terrain& terrain,
                   const StreetProfile& profile);

}  // namespace tvl::sim
