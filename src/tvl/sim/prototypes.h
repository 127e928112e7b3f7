// The things a town repeats: trees, cars, lamp posts.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/sim/furniture.h"
#include "tvl/sim/mesh.h"

namespace tvl::sim {

// Prototypes of one kind: numbers [first, first + count) of Prototypes::meshes.
struct PrototypeRange {
  uint32_t first = 0, count = 0;
  uint32_t Pick(Rng* rng) const { return first + static_cast<uint32_t>(rng->Integer(count)); }
};

inline constexpr double kHedgePiece_m = 2.0, kFencePiece_m = 2.0;

struct Prototypes {
  std::vector<Mesh> meshes;
  PrototypeRange broadleaf, conifer, hedge, bush;  // street trees: crowns within 2.4 m
  PrototypeRange big_tree;                         // crowns of 3-4 m, for parks and backyards
  PrototypeRange lamp, sign, bin, bollard, cabinet, bench, fence, wall;
  PrototypeRange car, van, pedestrian, cyclist;
  PrototypeRange lorry;              // kinds of BuildLorry
  std::vector<CarShape> car_shapes;  // of car, then van
  // Shape of a prototype out of car or van.
  const CarShape& ShapeOf(uint32_t prototype) const { return car_shapes[prototype - car.first]; }
  // Of a prototype out of car, van or lorry.
  double LengthOf_m(uint32_t prototype) const;
};

Prototypes BuildPrototypes(uint64_t seed);

}  // namespace tvl::sim
