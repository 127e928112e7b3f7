// Houses with relief: recessed windows, sills, balconies, bays, plinths, roofs with eaves.
#pragma once

#include <cstdint>

#include "tvl/base/rng.h"
#include "tvl/sim/mesh.h"

namespace tvl::sim {

struct HouseStyle {
  double width_m = 12.0, depth_m = 10.0;
  int floors = 2;
  double floor_height_m = 2.9;
  Material facade = Material::kPlaster;
  bool has_gable = true;                                      // else a flat roof with a parapet
  double bay_probability = 0.15, balcony_probability = 0.25;  // a window column
  double window_width_m = 1.1, window_height_m = 1.35;
  double recess_m = 0.14;  // of the windows
};

// A style drawn at random for the given plot.
HouseStyle RandomHouseStyle(double width_m, double depth_m, bool is_row_house, Rng* rng);

// x along the front to the right as seen from the street, y towards the back, z up from the
// ground; origin at the middle of the front. The walls reach 1 m below the ground, for slopes.
Mesh BuildHouse(const HouseStyle& style, Rng* rng);

}  // namespace tvl::sim
