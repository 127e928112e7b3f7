// Where a simulated drive leads.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "tvl/sim/polyline.h"

namespace tvl::sim {

// The driven lane lies this far to the right of the middle of the street.
inline constexpr double kLaneOffset_m = 1.7;

struct Route {
  Polyline lane;                // the line driven
  std::vector<Polyline> axes;   // middles of streets: the driven ones, and side streets
  std::vector<double> stops_m;  // where along the lane the vehicle stops for some seconds
  double tunnel_begin_m = 0.0, tunnel_end_m = 0.0;  // along the lane; empty if equal
  // The lane lies this far to the left of its usual place in the street from shift_end_m on, and
  // gradually so from shift_begin_m.
  double shift_m = 0.0, shift_begin_m = 0.0, shift_end_m = 0.0;
  // To the left of the usual place, m.
  double ShiftAt(double way_m) const;
};

// The route with its lane moved to the left from `way_m` on, over 40 m before that. Stops stay
// where they are along the lane.
Route ShiftedFrom(Route route, double way_m, double left_m);

// The route of a preset, long enough for travel_m. `closing_m` is how far the vehicle has come
// when a loop of the presets loop, nightloop and lateloop (or the turn-back of reverse) closes.
Route PlanRoute(const std::string& preset, uint64_t seed, double travel_m, double closing_m);

// The route of a line driven already; the street's axis lies to the left of it, side streets are
// added.
Route RouteAlong(const Polyline& lane, uint64_t seed);

}  // namespace tvl::sim
