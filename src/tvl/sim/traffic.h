// What moves in the town: cars, cyclists, pedestrians.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sim/lane_pose.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/vehicle.h"

namespace tvl::sim {

struct TrafficOptions {
  uint64_t seed = 1;
  double oncoming_every_s = 9.0;     // mean time between oncoming cars; 0: none
  double pedestrian_every_m = 11.0;  // mean distance between pedestrians met; 0: none
  int leaders = 1, followers = 1;    // cars in the own lane, ahead and behind
  double leader_gap_s = 8.0;         // mean time the leaders are ahead
};

// Passers who would come within 2.8 m of the ego vehicle stay away: where a shifted lane leaves no
// room, nobody comes towards it. Movers follow the streets of the route and are where they are by
// time alone, so that any instant can be asked for. Const and thread-safe.
class Traffic : public MoverSource {
 public:
  Traffic(const Route& route, const Terrain& terrain, const TravelProfile& travel,
          const Prototypes& prototypes, double duration_s, const TrafficOptions& options);

  std::vector<SceneMover> Movers(double begin_s, double end_s) const override;

 private:
  // Meets the ego vehicle at meet_s; before and after, it keeps its speed along `line`.
  struct Passer {
    uint32_t prototype;
    double meet_s, meet_way_m;  // when, and where along `line`
    double speed_m_s;           // along `line`, negative: against it
    double reach_m;             // exists as long as it is this close to where they meet
    double left_m;              // beside `line` as it usually lies in the street
  };
  // Drives in the own lane, a varying time ahead (positive) or behind.
  struct Companion {
    uint32_t prototype;
    double lead_s, swing_s, period_s, phase_rad;
  };

  double CompanionWay(const Companion& companion, double time_s) const;
  bool MeetsEgo(const Passer& passer) const;
  void AddOncoming(const Prototypes& prototypes, double duration_s, const TrafficOptions& options);
  void AddPedestrians(const Prototypes& prototypes, double duration_s,
                      const TrafficOptions& options);
  void AddCompanions(const Prototypes& prototypes, const TrafficOptions& options);

  LanePoses poses_;
  TravelProfile travel_;
  std::vector<Passer> passers_;
  std::vector<Companion> companions_;
};

}  // namespace tvl::sim
