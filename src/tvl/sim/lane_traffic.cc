#include "tvl/sim/lane_traffic.h"

#include <cmath>
#include <utility>

#include "tvl/base/check.h"

namespace tvl::sim {

LaneTraffic::LaneTraffic(LanePoses poses, TravelProfile ego, std::vector<Flow> flows,
                         std::vector<LaneVehicle> vehicles, double reach_m)
    : poses_(std::move(poses)),
      ego_(std::move(ego)),
      flows_(std::move(flows)),
      vehicles_(std::move(vehicles)),
      reach_m_(reach_m) {
  for (const LaneVehicle& vehicle : vehicles_) {
    TVL_CHECK(vehicle.flow < flows_.size()) << "flow " << vehicle.flow;
  }
}

double LaneTraffic::Way_m(const LaneVehicle& v, double time_s) const {
  return flows_[v.flow].Way_m(time_s - v.delay_s) + v.offset_m;
}

std::vector<SceneMover> LaneTraffic::Movers(double begin_s, double end_s) const {
  std::vector<SceneMover> movers;
  const double ego_m = ego_.Way_m(0.5 * (begin_s + end_s));
  for (size_t i = 0; i < vehicles_.size(); ++i) {
    const LaneVehicle& v = vehicles_[i];
    const double begin_m = Way_m(v, begin_s), end_m = Way_m(v, end_s);
    if (std::abs(0.5 * (begin_m + end_m) - ego_m) > reach_m_) continue;
    movers.push_back({v.prototype, static_cast<uint32_t>(i),
                      poses_.At(begin_m, v.left_m, v.is_reversed),
                      poses_.At(end_m, v.left_m, v.is_reversed)});
  }
  return movers;
}

}  // namespace tvl::sim
