// Vehicles in lanes beside, ahead of and behind the ego vehicle, each lane with a flow of its own:
// a jam, lorries that pass a standing car, the few cars of an open highway.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sim/flow.h"
#include "tvl/sim/lane_pose.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/vehicle.h"

namespace tvl::sim {

// One vehicle: its middle is at flow.Way_m(time - delay_s) + offset_m along the ego vehicle's lane.
// In a lane of flow F, vehicles that copy the one ahead after a delay and keep a distance never
// collide (Newell, Transportation Research B 36, 2002).
struct LaneVehicle {
  uint32_t prototype = 0;
  size_t flow = 0;      // of LaneTraffic's flows
  double left_m = 0.0;  // of the ego vehicle's lane
  double offset_m = 0.0, delay_s = 0.0;
  bool is_reversed = false;  // faces against the lane
};

// Const and thread-safe.
class LaneTraffic : public MoverSource {
 public:
  // Vehicles farther than reach_m from the ego vehicle are left out.
  LaneTraffic(LanePoses poses, TravelProfile ego, std::vector<Flow> flows,
              std::vector<LaneVehicle> vehicles, double reach_m);

  std::vector<SceneMover> Movers(double begin_s, double end_s) const override;

  const std::vector<LaneVehicle>& vehicles() const { return vehicles_; }
  const std::vector<Flow>& flows() const { return flows_; }
  // Way of a vehicle's middle along the ego vehicle's lane.
  double Way_m(const LaneVehicle& vehicle, double time_s) const;

 private:
  LanePoses poses_;
  TravelProfile ego_;
  std::vector<Flow> flows_;
  std::vector<LaneVehicle> vehicles_;
  double reach_m_;
};

}  // namespace tvl::sim
