// Houses, their gardens, parks and what lies behind them.
#pragma once

#include "tvl/sim/site.h"

namespace tvl::sim {

// One side of a street: where along it things may stand.
struct StreetSide {
  const Polyline* axis;
  double side;  // +1 left, -1 right of the axis
  double begin_m, end_m;
  double setback_m = 0.0;  // added to all distances
  // A point beside the street.
  Eigen::Vector2d At(double s_m, double distance_m) const;
  Eigen::Vector2d Outwards(double s_m) const;  // unit, away from the street
};

// Rows of houses, detached houses with gardens, and parks, changing every 50-110 m.
void FillPlots(const StreetSide& side, Rng* rng, Site* site);
// The same house again and again.
void FillPlotsAlike(const StreetSide& side, Site* site);
// Trees, bushes and further houses behind the plots.
void FillBackyards(const StreetSide& side, Rng* rng, Site* site);
// What closes the view at the end of a street.
void CloseStreetEnd(const Polyline& axis, bool at_begin, Rng* rng, Site* site);

}  // namespace tvl::sim
