// Small things that stand beside a street, and things that move on it.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/sim/mesh.h"

namespace tvl::sim {

// All stand at the origin on the ground, z up.
Mesh BuildLampPost();             // arm along +x
Mesh BuildTrafficSign(int kind);  // faces -x: disc, triangle or board
Mesh BuildBin();
Mesh BuildBollard();
Mesh BuildCabinet();  // telephone or mains, 0.8 x 0.4 x 1.2
Mesh BuildBench();
// Along x from 0 to length_m.
Mesh BuildPicketFence(double length_m);
Mesh BuildGardenWall(double length_m);

// x forward, y left, z up from the road; origin in the middle.
struct CarShape {
  double length_m = 4.3, width_m = 1.75, height_m = 1.46;
  double hood_m = 1.0;    // from the front to the windscreen's foot
  double trunk_m = 0.45;  // from the rear window's foot to the rear; 0: hatchback
  double belt_m = 0.92;   // height of the window sills
  bool is_box = false;    // van or lorry: straight sides
};
// Shapes of a town's traffic: small car, saloon, estate, off-roader, van, lorry.
std::vector<CarShape> CarShapes();
Mesh BuildCar(const CarShape& shape);

// A standing or walking person, x forward. `stride` in 0..1 spreads the legs.
Mesh BuildPedestrian(double height_m, double stride);
Mesh BuildCyclist();

}  // namespace tvl::sim
