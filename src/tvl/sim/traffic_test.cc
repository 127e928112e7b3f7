#include "tvl/sim/traffic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tvl/geometry/rigid3_matchers.h"

namespace tvl::sim {
namespace {

class TrafficTest : public ::testing::Test {
 protected:
  static constexpr double kDuration_s = 60.0;

  TrafficTest()
      : route_(PlanRoute("city", 4, 900.0, 0.0)),
        terrain_(Terrain::Rolling(4)),
        travel_(route_, {}, 4, kDuration_s + 30.0),
        prototypes_(BuildPrototypes(4)) {}

  Traffic Make(const TrafficOptions& options) const {
    return Traffic(route_, terrain_, travel_, prototypes_, kDuration_s, options);
  }

  Route route_;
  Terrain terrain_;
  TravelProfile travel_;
  Prototypes prototypes_;
};

TEST_F(TrafficTest, NobodyRunsIntoTheEgoVehicle) {
  TrafficOptions options;
  options.oncoming_every_s = 3.0, options.leaders = 3, options.followers = 2;
  options.leader_gap_s = 4.0;
  const Traffic traffic = Make(options);
  size_t met = 0;
  for (double t = 0.0; t < kDuration_s; t += 0.5) {
    const Eigen::Vector2d ego = route_.lane.At(travel_.Way_m(t));
    for (const SceneMover& m : traffic.Movers(t, t)) {
      ++met;
      EXPECT_GT((m.T_world_object_begin.t().head<2>() - ego).norm(), 2.7) << "at " << t;
    }
  }
  EXPECT_GT(met, 500U);
}

TEST_F(TrafficTest, MoversGoOnSmoothlyFromSweepToSweep) {
  const Traffic traffic = Make({});
  std::map<uint32_t, Rigid3d> before;
  size_t followed = 0, moving = 0;
  for (int k = 0; k < 300; ++k) {
    const double t = 0.1 * k;
    std::map<uint32_t, Rigid3d> now;
    for (const SceneMover& m : traffic.Movers(t, t + 0.1)) {
      const auto last = before.find(m.id);
      if (last != before.end()) {
        EXPECT_THAT(m.T_world_object_begin, Rigid3dNear(last->second, 1e-9, 1e-9));
        ++followed;
      }
      const double step = (m.T_world_object_end.t() - m.T_world_object_begin.t()).norm();
      EXPECT_LT(step, 2.5) << "25 m/s";
      moving += step > 0.05 ? 1 : 0;
      now[m.id] = m.T_world_object_end;
    }
    before = now;
  }
  EXPECT_GT(followed, 1000U);
  EXPECT_GT(moving, 500U);
}

// The ego vehicle changes its place in the street, the others do not.
TEST_F(TrafficTest, PassersKeepTheirPlaceInTheStreet) {
  const Route shifted = ShiftedFrom(route_, 100.0, 0.5);
  const Traffic traffic(shifted, terrain_, travel_, prototypes_, kDuration_s, {});
  const PolylineIndex axis({route_.axes.front()}, 16.0);
  size_t oncoming = 0, astray = 0;
  for (double t = 20.0; t < kDuration_s; t += 0.5) {
    for (const SceneMover& m : traffic.Movers(t, t)) {
      if (m.prototype < prototypes_.car.first || m.prototype >= prototypes_.van.first + 2) continue;
      const double from_axis = axis.Distance(m.T_world_object_begin.t().head<2>());
      const bool is_oncoming = std::abs(from_axis - kLaneOffset_m) < 0.2;
      const bool is_companion = std::abs(from_axis - kLaneOffset_m + 0.5) < 0.2;
      oncoming += is_oncoming ? 1 : 0;
      astray += is_oncoming || is_companion ? 0 : 1;
    }
  }
  EXPECT_GT(oncoming, 20U);
  EXPECT_LT(astray, oncoming / 10) << "corners are cut a little";
}

TEST_F(TrafficTest, CanBeSwitchedOff) {
  TrafficOptions options;
  options.oncoming_every_s = 0.0, options.pedestrian_every_m = 0.0;
  options.leaders = options.followers = 0;
  EXPECT_TRUE(Make(options).Movers(10.0, 10.1).empty());
}

}  // namespace
}  // namespace tvl::sim
