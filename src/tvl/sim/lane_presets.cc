#include "tvl/sim/lane_presets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

constexpr uint64_t kFlowStream = 811, kLaneStream = 821, kHighwayStream = 831;
// Vehicles of a lane copy what one ahead did up to a minute ago.
constexpr double kMemory_s = 60.0;
constexpr double kJamReach_m = 150.0;      // beyond the lidar's sight
constexpr double kHighwayReach_m = 250.0;  // a car is 6 pixels wide there

uint32_t JamVehicle(const Prototypes& p, double lorry_share, Rng* rng) {
  const double draw = rng->Uniform();
  if (draw < lorry_share) return p.lorry.Pick(rng);
  return draw < lorry_share + 0.12 ? p.van.Pick(rng) : p.car.Pick(rng);
}

// Adds the vehicles ahead of (sign 1) or behind (-1) `first`, which has the given length.
void Queue(const LaneVehicle& first, double first_length_m, double sign, double reach_m,
           double lorry_share, const Prototypes& prototypes, Rng* rng,
           std::vector<LaneVehicle>* vehicles) {
  LaneVehicle last = first;
  double length = first_length_m;
  while (std::abs(last.offset_m - first.offset_m) < reach_m) {
    LaneVehicle next = last;
    next.prototype = JamVehicle(prototypes, lorry_share, rng);
    const double next_length = prototypes.LengthOf_m(next.prototype);
    const double gap = rng->Uniform(1.8, 3.5);
    next.offset_m += sign * (0.5 * length + gap + 0.5 * next_length);
    next.delay_s -= sign * rng->Uniform(0.7, 1.1);
    next.left_m = first.left_m + rng->Uniform(-0.12, 0.12);
    vehicles->push_back(next);
    last = next, length = next_length;
  }
}

// The lanes left, right and second to the left, each with one of the flows 1..3.
std::array<size_t, 3> ShuffledFlows(Rng* rng) {
  std::array<size_t, 3> flows = {1, 2, 3};
  for (size_t i = 2; i > 0; --i) {
    std::swap(flows[i], flows[static_cast<size_t>(rng->Integer(static_cast<int64_t>(i) + 1))]);
  }
  return flows;
}

}  // namespace

JamFlows PlanJam(uint64_t seed, double duration_s) {
  Rng rng(seed, kFlowStream);
  const double begin_s = -kMemory_s, end_s = duration_s + kMemory_s;
  StopAndGoOptions fast, slow;
  fast.low_m_s = 1.5, fast.high_m_s = 5.0, fast.stand_low_s = 1.0, fast.stand_high_s = 3.0;
  slow.low_m_s = 0.5, slow.high_m_s = 1.6, slow.stand_low_s = 3.0, slow.stand_high_s = 7.0;
  const Rng own = rng;
  Rng first = own, again = own;
  Flow ego = StopAndGo({}, begin_s, end_s, &first);
  // The same stops and starts, later: as if it were asked for from an earlier time on.
  constexpr double kLater_s = 0.8;
  Flow equal = StopAndGo({}, begin_s + kLater_s, end_s + kLater_s, &again);
  Flow faster = StopAndGo(fast, begin_s, end_s, &first);
  return {std::move(ego), std::move(faster), StopAndGo(slow, begin_s, end_s, &first),
          std::move(equal)};
}

LaneTraffic JamTraffic(const LanePoses& poses, const TravelProfile& ego,
                       const Prototypes& prototypes, double duration_s, uint64_t seed) {
  constexpr double kEgoLength_m = 4.8;
  Rng rng(seed, kLaneStream);
  JamFlows jam = PlanJam(seed, duration_s);
  const std::vector<Flow> flows = {jam.ego, jam.faster, jam.slower, jam.equal};
  const double middle_s = 0.5 * duration_s;
  std::vector<LaneVehicle> vehicles;

  LaneVehicle own;
  own.offset_m = ego.Way_m(0.0);
  const double reach_m = kJamReach_m + flows[1].Way_m(duration_s);
  Queue(own, kEgoLength_m, 1.0, reach_m, 0.2, prototypes, &rng, &vehicles);
  Queue(own, kEgoLength_m, -1.0, reach_m, 0.4, prototypes, &rng, &vehicles);

  const std::array<size_t, 3> flow_of = ShuffledFlows(&rng);
  const std::array<double, 3> left_m = {kLaneWidth_m, -kLaneWidth_m, 2.0 * kLaneWidth_m};
  for (size_t lane = 0; lane < 3; ++lane) {
    LaneVehicle beside;
    // One of the long kinds.
    beside.prototype = prototypes.lorry.first + static_cast<uint32_t>(rng.Integer(2));
    beside.flow = flow_of[lane], beside.left_m = left_m[lane];
    beside.offset_m =
        ego.Way_m(middle_s) + rng.Uniform(-1.0, 2.5) - flows[beside.flow].Way_m(middle_s);
    vehicles.push_back(beside);
    const double length_m = prototypes.LengthOf_m(beside.prototype);
    for (const double sign : {1.0, -1.0}) {
      Queue(beside, length_m, sign, reach_m, 0.6, prototypes, &rng, &vehicles);
    }
  }
  return LaneTraffic(poses, ego, flows, std::move(vehicles), kJamReach_m);
}

LaneTraffic PassingTraffic(const LanePoses& poses, const TravelProfile& ego,
                           const Prototypes& prototypes, double duration_s) {
  constexpr double kSpeed_m_s = 5.0;
  std::vector<LaneVehicle> lorries(2);
  for (uint32_t i = 0; i < 2; ++i) {
    lorries[i].prototype = prototypes.lorry.first + i;
    lorries[i].left_m = i == 0 ? kLaneWidth_m : -kLaneWidth_m;
    lorries[i].offset_m = ego.Way_m(0.0) - kSpeed_m_s * 0.5 * duration_s;
  }
  return LaneTraffic(poses, ego, {Flow(kSpeed_m_s)}, std::move(lorries), kJamReach_m);
}

LaneTraffic HighwayTraffic(const LanePoses& poses, const TravelProfile& ego,
                           const Prototypes& prototypes, double duration_s, double speed_m_s,
                           uint64_t seed) {
  Rng rng(seed, kHighwayStream);
  std::vector<Flow> flows;
  std::vector<LaneVehicle> vehicles;
  const auto add = [&](double speed, double left_m, double offset_m, bool is_reversed) {
    LaneVehicle vehicle;
    vehicle.prototype = JamVehicle(prototypes, 0.15, &rng);
    vehicle.flow = flows.size(), vehicle.left_m = left_m, vehicle.offset_m = offset_m;
    vehicle.is_reversed = is_reversed;
    flows.emplace_back(speed);
    vehicles.push_back(vehicle);
  };
  for (const double ahead_m : {rng.Uniform(75.0, 100.0), rng.Uniform(140.0, 190.0)}) {
    add(speed_m_s + rng.Uniform(0.0, 0.4), 0.0, ego.Way_m(0.0) + ahead_m, false);
  }
  const double oncoming_m_s = speed_m_s * rng.Uniform(0.9, 1.1);  // nobody overtakes
  for (double meet_s = rng.Uniform(2.0, 12.0); meet_s < duration_s;
       meet_s += rng.Uniform(6.0, 16.0)) {
    add(-oncoming_m_s, 2.0 * kLaneOffset_m, ego.Way_m(meet_s) + oncoming_m_s * meet_s, true);
  }
  return LaneTraffic(poses, ego, std::move(flows), std::move(vehicles), kHighwayReach_m);
}

}  // namespace tvl::sim
