// The traffic of the presets jam, passing and highway.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sim/lane_traffic.h"

namespace tvl::sim {

// Traffic of a jam, by seed: the ego vehicle's own way, that of a lane that is faster on average,
// one that is slower, and one that does what the ego vehicle does, a moment later.
struct JamFlows {
  Flow ego, faster, slower, equal;
};
JamFlows PlanJam(uint64_t seed, double duration_s);

// Four lanes of lorries and cars (FourLanes), the ego vehicle in the second from the right. In the
// middle of the drive lorries stand or roll on both sides of it. `ego` must follow PlanJam's.
LaneTraffic JamTraffic(const LanePoses& poses, const TravelProfile& ego,
                       const Prototypes& prototypes, double duration_s, uint64_t seed);

// Two lorries of 14 m that pass the standing ego vehicle left and right at 5 m/s, side by side, in
// the middle of the drive. Nothing else moves.
LaneTraffic PassingTraffic(const LanePoses& poses, const TravelProfile& ego,
                           const Prototypes& prototypes, double duration_s);

// Two cars far ahead and some that come towards the ego vehicle, which keeps to speed_m_s.
LaneTraffic HighwayTraffic(const LanePoses& poses, const TravelProfile& ego,
                           const Prototypes& prototypes, double duration_s, double speed_m_s,
                           uint64_t seed);

}  // namespace tvl::sim
