// The building site: where things may be put while a town is made.
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "tvl/sim/ground.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/route.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

// An upright box seen from above.
struct Footprint {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();  // unit
  double half_length_m = 0.5, half_width_m = 0.5;    // along, across
};

bool Overlap(const Footprint& a, const Footprint& b);

// What must stay free around a thing.
struct Clearance {
  double lane_m = 1.9;  // from the driven line to its outline; the promise is 1.5
  double axis_m = 0.0;  // from any street's axis to its outline
  bool blocks = true;   // nothing else may stand on its footprint
};

// Keeps track of what stands where. Order of calls decides, so that a town is reproducible.
class Site {
 public:
  Site(const Route& route, const Terrain& terrain, const StreetProfile& profile,
       const Prototypes& prototypes, SceneDescription* description);

  const Route& route() const { return route_; }
  const Prototypes& prototypes() const { return prototypes_; }
  const StreetProfile& profile() const { return profile_; }
  double AxisDistance(const Eigen::Vector2d& p) const { return axes_.Distance(p); }
  // Height of the finished ground.
  double GroundHeight(const Eigen::Vector2d& p) const;
  // Free of other things, and as far from lane and axes as asked.
  bool IsFree(const Footprint& footprint, const Clearance& clearance) const;

  // Put a prototype or a mesh at p, its x axis along `x_direction`, upright. Return whether there
  // was room.
  bool TryPlace(uint32_t prototype, const Eigen::Vector2d& p, const Eigen::Vector2d& x_direction,
                const Footprint& footprint, const Clearance& clearance);
  void Build(Mesh mesh, const Eigen::Vector2d& p, const Eigen::Vector2d& x_direction,
             const Footprint& footprint);

 private:
  void Occupy(const Footprint& footprint);
  Rigid3d Upright(const Eigen::Vector2d& p, const Eigen::Vector2d& x_direction) const;

  const Route& route_;
  const Terrain& terrain_;
  StreetProfile profile_;
  const Prototypes& prototypes_;
  SceneDescription* description_;
  PolylineIndex lanes_, axes_;
  std::vector<Footprint> taken_;
  std::map<std::pair<int, int>, std::vector<size_t>> cells_;  // taken_ by cell of kCell_m
};

}  // namespace tvl::sim
