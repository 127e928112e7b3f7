#include "tvl/sim/traffic.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

constexpr uint64_t kTrafficStream = 601;
constexpr double kCarReach_m = 150.0;  // beyond the lidar's sight
constexpr double kPedestrianReach_m = 60.0;
constexpr double kEgoLength_m = 6.0;

}  // namespace

Traffic::Traffic(const Route& route, const Terrain& terrain, const TravelProfile& travel,
                 const Prototypes& prototypes, double duration_s, const TrafficOptions& options)
    : poses_(route, terrain, {}), travel_(travel) {
  if (options.oncoming_every_s > 0.0) AddOncoming(prototypes, duration_s, options);
  if (options.pedestrian_every_m > 0.0) AddPedestrians(prototypes, duration_s, options);
  AddCompanions(prototypes, options);
}

void Traffic::AddOncoming(const Prototypes& prototypes, double duration_s,
                          const TrafficOptions& options) {
  Rng rng(options.seed, kTrafficStream);
  const double mean = options.oncoming_every_s;
  const double speed = rng.Uniform(8.0, 11.0);  // of all: they do not overtake each other
  for (double t = rng.Uniform(0.0, mean); t < duration_s;
       t += 1.5 + rng.Uniform(0.0, 2.0 * (mean - 1.5))) {
    const double draw = rng.Uniform();
    Passer passer{prototypes.car.Pick(&rng),        t,           travel_.Way_m(t),
                  -speed * rng.Uniform(0.97, 1.03), kCarReach_m, 2.0 * kLaneOffset_m};
    if (draw < 0.15) passer.prototype = prototypes.van.Pick(&rng);
    if (draw > 0.9) {
      passer.prototype = prototypes.cyclist.first;
      passer.speed_m_s *= 0.5;
      passer.left_m += 0.8;
    }
    if (!MeetsEgo(passer)) passers_.push_back(passer);
  }
}

void Traffic::AddPedestrians(const Prototypes& prototypes, double duration_s,
                             const TrafficOptions& options) {
  Rng rng(options.seed, kTrafficStream + 1);
  const double end = travel_.Way_m(duration_s) + 40.0;
  for (double way = 5.0; way < end; way += rng.Uniform(0.1, 2.0) * options.pedestrian_every_m) {
    const double beside = rng.Uniform(6.3, 7.3);
    const double left = kLaneOffset_m + (rng.Uniform() < 0.5 ? beside : -beside);
    const double speed = (rng.Uniform() < 0.5 ? 1.0 : -1.0) * rng.Uniform(0.7, 1.6);
    passers_.push_back({prototypes.pedestrian.Pick(&rng), travel_.TimeAt(way), way,
                        rng.Uniform() < 0.2 ? 0.0 : speed, kPedestrianReach_m, left});
  }
}

void Traffic::AddCompanions(const Prototypes& prototypes, const TrafficOptions& options) {
  Rng rng(options.seed, kTrafficStream + 2);
  double lead = options.leader_gap_s;
  for (int i = 0; i < options.leaders; ++i, lead += 3.0) {
    // All leaders swing together, so that they keep their order.
    companions_.push_back({prototypes.car.Pick(&rng), lead, 0.7 * options.leader_gap_s, 70.0,
                           1.0 + static_cast<double>(options.seed % 6)});
  }
  for (int i = 0; i < options.followers; ++i) {
    companions_.push_back({prototypes.car.Pick(&rng), -4.0 - 3.0 * i, 1.8, 90.0, 2.0});
  }
}

bool Traffic::MeetsEgo(const Passer& passer) const {
  const double life_s = passer.reach_m / std::max(0.1, std::abs(passer.speed_m_s));
  for (double t = passer.meet_s - life_s; t < passer.meet_s + life_s; t += 0.1) {
    const double way = passer.meet_way_m + passer.speed_m_s * (t - passer.meet_s);
    const Vector2d p = poses_.Beside(way, passer.left_m - poses_.route().ShiftAt(way));
    if ((p - poses_.route().lane.At(travel_.Way_m(t))).norm() < 2.8) return true;
  }
  return false;
}

double Traffic::CompanionWay(const Companion& c, double time_s) const {
  const double swing = c.swing_s * std::sin(2.0 * kPi * time_s / c.period_s + c.phase_rad);
  const double sign = c.lead_s > 0.0 ? 1.0 : -1.0;
  return travel_.Way_m(time_s + c.lead_s + swing) + sign * kEgoLength_m;
}

std::vector<SceneMover> Traffic::Movers(double begin_s, double end_s) const {
  std::vector<SceneMover> movers;
  for (size_t i = 0; i < passers_.size(); ++i) {
    const Passer& p = passers_[i];
    const auto gone = [&](double t) { return p.speed_m_s * (t - p.meet_s); };
    const double near_m = std::abs(gone(0.5 * (begin_s + end_s)));
    const double ego_m = std::abs(travel_.Way_m(begin_s) - p.meet_way_m);
    if (near_m > p.reach_m || ego_m > kCarReach_m) continue;
    const bool is_reversed = p.speed_m_s < 0.0;
    const auto pose = [&](double t) {
      const double way = p.meet_way_m + gone(t);
      return poses_.At(way, p.left_m - poses_.route().ShiftAt(way), is_reversed);
    };
    movers.push_back({p.prototype, static_cast<uint32_t>(i), pose(begin_s), pose(end_s)});
  }
  for (size_t i = 0; i < companions_.size(); ++i) {
    const Companion& c = companions_[i];
    const double begin_m = CompanionWay(c, begin_s), end_m = CompanionWay(c, end_s);
    if (std::abs(begin_m - travel_.Way_m(begin_s)) > kCarReach_m) continue;
    movers.push_back({c.prototype, static_cast<uint32_t>(passers_.size() + i),
                      poses_.At(begin_m, 0.0, false), poses_.At(end_m, 0.0, false)});
  }
  return movers;
}

}  // namespace tvl::sim
