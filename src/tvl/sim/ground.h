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
};

// Height of the surface over the terrain at a distance from the nearest axis, m.
double ProfileHeight(const StreetProfile& profile, double distance_m);

// The ground around `axes`, world frame.
Mesh BuildGround(const std::vector<Polyline>& axes, const Terrain& terrain,
                 const StreetProfile& profile);

// Dashed centre lines on the axes, world frame..
Mesh BuildMarkings(const std::vector<Polyline>& axes, const Terrain& terrain,
                   const StreetProfile& profile);

}  // namespace tvl::sim
