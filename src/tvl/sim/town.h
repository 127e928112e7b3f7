// A procedural town along a route.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "tvl/sim/ground.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/route.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

struct TownOptions {
  uint64_t seed = 1;
  bool is_open = false;       // a plain with few features, everywhere
  bool is_repeating = false;  // identical houses at equal distances
  bool has_parked_cars = true;
  bool has_street_ends = true;  // houses where the streets end
  double setback_m = 0.0;       // everything stands this much farther from the street than usual
  StreetProfile profile;
  // Stretches [begin, end) of the lane, m, without town beside them.
  std::vector<std::pair<double, double>> open_m;
  // The same without anything: only a line of trees far off, 118-150 m from the street.
  std::vector<std::pair<double, double>> bare_m;
};

// Everything that stands still: ground, houses, gardens, what stands at the kerb, parked cars, the
// tunnel of the route. Nothing but the ground and its paint lies within 1.5 m of the lane.
SceneDescription BuildTown(const Route& route, const Terrain& terrain, const Prototypes& prototypes,
                           const TownOptions& options);

}  // namespace tvl::sim
