// What stands between carriageway and plots: parked cars, street trees, lamps, signs.
#pragma once

#include "tvl/sim/plots.h"

namespace tvl::sim {

void ParkCars(const StreetSide& side, Rng* rng, Site* site);
void PlantAvenue(const StreetSide& side, Rng* rng, Site* site);
void PutFurniture(const StreetSide& side, Rng* rng, Site* site);
// Lamps at equal distances, nothing else.
void PutLampsAlike(const StreetSide& side, Site* site);
// Delineator posts and a rare tree: an open road.
void PutOpenRoad(const StreetSide& side, Rng* rng, Site* site);
// Trees farther from the street than a lidar sees: what closes the view over open country.
void PlantTreeLine(const StreetSide& side, Rng* rng, Site* site);

}  // namespace tvl::sim
