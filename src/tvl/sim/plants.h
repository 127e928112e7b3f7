// Porous plants: leaves are small cards, so that some of the lidar's pulses pass.
#pragma once

#include "tvl/base/rng.h"
#include "tvl/sim/mesh.h"

namespace tvl::sim {

// Stands at the origin; z up. The crown stays within radius_m of the trunk and above 2.2 m.
Mesh BuildBroadleaf(double height_m, double radius_m, Rng* rng);
Mesh BuildConifer(double height_m, double radius_m, Rng* rng);
// Along x from 0 to length_m, its thickness centred on y = 0.
Mesh BuildHedge(double length_m, double height_m, double thickness_m, Rng* rng);
Mesh BuildBush(double radius_m, Rng* rng);

}  // namespace tvl::sim
