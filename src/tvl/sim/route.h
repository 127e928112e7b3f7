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
  double start_m = 0.0;         // where along the lane the drive begins
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

struct RoadOptions {
  double behind_m = 250.0;  // of road before the start: more than the camera shows of it
  double ahead_m = 1000.0;  // and after it
  // Frame 0 lies in the middle of a bend of this radius, m, to the left or right by the seed. 0:
  // the road is straight.
  double bend_radius_m = 0.0;
  // Else it winds to and fro over 1200 m, no tighter than this radius, m; 0: it does not.
  double winding_radius_m = 0.0;
  bool has_side_streets = true;
};

// A road for drives that begin at speed. The vehicle starts at route.start_m.
Route PlanRoad(uint64_t seed, const RoadOptions& options);

// The radius of a bend for a drive at a speed: 2.5 m/s^2 across at most, and no less than the
// corner of two streets needs.
double BendRadius_m(double speed_m_s);

// The route of a line driven already; the street's axis lies to the left of it, side streets are
// added.
Route RouteAlong(const Polyline& lane, uint64_t seed);

}  // namespace tvl::sim
