// Lorries: long, high vehicles that fill the view of a car beside them.
#pragma once

#include "tvl/sim/mesh.h"

namespace tvl::sim {

// Kinds: a tractor with a curtain-sided trailer, one with a tank (14 m both), a dropside lorry that
// the town is seen over (9 m).
inline constexpr int kLorryKinds = 3;
double LorryLength_m(int kind);
// x forward, y left, z up from the road; origin in the middle.
Mesh BuildLorry(int kind);

}  // namespace tvl::sim
