// Where vehicles beside the driven lane stand.
#pragma once

#include "tvl/geometry/rigid3.h"
#include "tvl/sim/ground.h"
#include "tvl/sim/polyline.h"
#include "tvl/sim/route.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

// Const and thread-safe.
class LanePoses {
 public:
  LanePoses(const Route& route, const Terrain& terrain, const StreetProfile& profile);

  const Route& route() const { return route_; }
  // The place `left_m` to the left of the lane.
  Eigen::Vector2d Beside(double way_m, double left_m) const;
  // On the ground there, along the lane or against it: x forward, z up, T_world_object.
  Rigid3d At(double way_m, double left_m, bool is_reversed) const;

 private:
  Route route_;
  Terrain terrain_;
  StreetProfile profile_;
  PolylineIndex axes_;
};

}  // namespace tvl::sim
