// A tube without features of shape, for lidars to lose their way in.
#pragma once

#include "tvl/sim/mesh.h"
#include "tvl/sim/polyline.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

struct TunnelOptions {
  double radius_m = 4.0;        // of the vault
  double axis_height_m = 1.5;   // of the tube's axis above the road: the chord is the road
  double floor_above_m = 0.03;  // of the flat road over the street it replaces
};

// The tube around [begin_m, end_m] of the lane, with a portal at both ends; world frame.
Mesh BuildTunnel(const Polyline& lane, double begin_m, double end_m, const Terrain& terrain,
                 const TunnelOptions& options = {});

}  // namespace tvl::sim
