// How a car drives along a route.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/sim/polyline.h"
#include "tvl/sim/route.h"
#include "tvl/sim/terrain.h"

namespace tvl::sim {

struct VehicleOptions {
  double cruise_m_s = 11.0;        // town traffic
  double acceleration_m_s2 = 1.5;  // ordinary driver
  double braking_m_s2 = 1.9;
  double lateral_m_s2 = 1.9;       // comfort limit in turns
  double variation = 1.0;          // of the cruising speed: 1 as in a town, +-20 %; 0: none
  double tunnel_variation = 0.0;   // share by which the speed varies inside a tunnel
  double faster_after_stop = 0.0;  // speed and acceleration are this share higher then
  double pitch_per_m_s2 = 0.005;   // rad of squat per m/s^2 along
  double roll_per_m_s2 = 0.008;    // rad of lean per m/s^2 across
  double roughness_m = 0.006;      // amplitude of heave; pitch and roll follow from it
};

// Way along the lane as a function of time from 0. A planned one accelerates from standstill or
// rolling, brakes for bends and stops. At least duration_s long.
class TravelProfile {
 public:
  TravelProfile(const Route& route, const VehicleOptions& options, uint64_t seed,
                double duration_s);
  // From the way at each multiple of interval_s.
  TravelProfile(std::vector<double> way_m, double interval_s);
  double Way_m(double time_s) const;  // linear beyond both ends
  double Speed_m_s(double time_s) const;
  // The first instant at which the way is reached.
  double TimeAt(double way_m) const;

 private:
  double interval_s_;
  std::vector<double> way_m_;
};

// Pose of the vehicle at time_s: origin on the ground below the lidar, x forward, z up. Follows
// the slope of the ground, the suspension and the roughness of the road.
Rigid3d VehiclePose(const Route& route, const Terrain& terrain, const TravelProfile& travel,
                    const VehicleOptions& options, uint64_t seed, double time_s);

}  // namespace tvl::sim
