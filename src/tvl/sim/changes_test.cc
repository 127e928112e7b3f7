#include "tvl/sim/changes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/sim/drive.h"
#include "tvl/sim/town.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// A block driven around for 54 s and half again; without traffic.
struct Town {
  Drive drive;
  Prototypes prototypes;
  SceneDescription description;

  explicit Town(double lateral_m = 0.0) : drive(PlanDrive(Options(lateral_m), Rigid3d())) {
    prototypes = BuildPrototypes(3);
    TownOptions town;
    town.seed = 3;
    description = BuildTown(drive.route, drive.terrain, prototypes, town);
  }
  static SimOptions Options(double lateral_m) {
    SimOptions options;
    options.preset = "loop", options.frames = 900, options.seed = 3;
    options.lateral_m = lateral_m;
    return options;
  }
  SceneDescription Changed(double share) const {
    ChangeOptions options;
    options.seed = 3, options.share = share;
    return WithChanges(description, prototypes, {drive.T_world_lidar, 90.0}, options);
  }
  bool IsCar(uint32_t prototype) const {
    return prototype >= prototypes.car.first && prototype < prototypes.van.first + 2;
  }
  Vector3d EyeAt(double time_s) const { return drive.T_world_lidar.At(time_s).t(); }
};

std::vector<Stay> StaysIn(const SceneDescription& description) {
  return dynamic_cast<const ChangingThings&>(*description.movers).stays();
}

TEST(ChangesTest, NoShareNoChange) {
  const Town town;
  const SceneDescription same = town.Changed(0.0);
  EXPECT_EQ(same.movers, nullptr);
  ASSERT_EQ(same.instances.size(), town.description.instances.size());
  for (size_t i = 0; i < same.instances.size(); ++i) {
    EXPECT_EQ(same.instances[i].prototype, town.description.instances[i].prototype);
    EXPECT_EQ(same.instances[i].T_world_object.t(),
              town.description.instances[i].T_world_object.t());
  }
  EXPECT_EQ(same.structures.size(), town.description.structures.size());
}

struct Count {
  int came = 0, gone = 0, replaced = 0;
};

Count CarsChanged(const Town& town, const std::vector<Stay>& stays) {
  Count count;
  for (const Stay& a : stays) {
    if (!town.IsCar(a.thing.prototype)) continue;
    const auto meets = [&](double Stay::*mine, double Stay::*other) {
      return std::any_of(stays.begin(), stays.end(), [&](const Stay& b) {
        return b.*other == a.*mine &&
               (a.thing.T_world_object.t() - b.thing.T_world_object.t()).norm() < 1.0;
      });
    };
    if (std::isfinite(a.end_s)) {
      meets(&Stay::end_s, &Stay::begin_s) ? ++count.replaced : ++count.gone;
    }
    if (std::isfinite(a.begin_s) && !meets(&Stay::begin_s, &Stay::end_s)) ++count.came;
  }
  return count;
}

TEST(ChangesTest, CarsComeGoAndMakeRoomForOthers) {
  const Town town;
  const Count all = CarsChanged(town, StaysIn(town.Changed(1.0)));
  EXPECT_GT(all.came, 10);
  EXPECT_GT(all.gone, 10);
  EXPECT_GT(all.replaced, 10);
  const Count half = CarsChanged(town, StaysIn(town.Changed(0.5)));
  const double share = static_cast<double>(half.came + half.gone + half.replaced) /
                       (all.came + all.gone + all.replaced);
  EXPECT_NEAR(share, 0.5, 0.15);
}

TEST(ChangesTest, WhatWasThereIsGoneAfterwards) {
  const Town town;
  const SceneDescription changed = town.Changed(1.0);
  const auto count = [&](const Stay& stay, double time_s) {
    const std::vector<SceneMover> movers = changed.movers->Movers(time_s, time_s);
    return std::count_if(movers.begin(), movers.end(), [&](const SceneMover& m) {
      return m.prototype == stay.thing.prototype &&
             m.T_world_object_begin.t() == stay.thing.T_world_object.t() &&
             m.T_world_object_end.t() == stay.thing.T_world_object.t();
    });
  };
  int checked = 0;
  for (const Stay& stay : StaysIn(changed)) {
    if (!town.IsCar(stay.thing.prototype) || !std::isfinite(stay.end_s)) continue;
    if (++checked > 40) break;
    EXPECT_EQ(count(stay, stay.end_s - 0.01), 1);
    EXPECT_EQ(count(stay, stay.end_s + 0.01), 0);
  }
  EXPECT_GT(checked, 20);
}

// Looked at from every frame near a change, over the roofs of the cars.
TEST(ChangesTest, NothingChangesInSight) {
  const Town town;
  SceneDescription houses;
  houses.structures = town.description.structures;
  const Scene scene(houses);
  const SceneView view = scene.View(0.0, 0.0);
  int changes = 0;
  for (const Stay& stay : StaysIn(town.Changed(1.0))) {
    for (const double change_s : {stay.begin_s, stay.end_s}) {
      if (!std::isfinite(change_s)) continue;
      ++changes;
      const Vector3d p = stay.thing.T_world_object * Vector3d(0, 0, 1.0);
      for (double t = change_s - 1.0; t < change_s + 1.0; t += 0.1) {
        const Vector3d ray = p - town.EyeAt(t);
        if (ray.head<2>().norm() > 120.0) continue;
        RayPacket rays;
        rays.Set(0, town.EyeAt(t).cast<float>(), ray.normalized().cast<float>(),
                 static_cast<float>(ray.norm()));
        EXPECT_EQ(view.Occluded(rays), 1U)
            << stay.thing.prototype << " seen at " << t << ", changes at " << change_s;
      }
    }
  }
  EXPECT_GT(changes, 100);
}

// Frames at which something stands within 1.5 m of the middle of the vehicle, at bumper, window
// and roof height.
std::vector<int> TightFrames(const Town& town, const Scene& scene) {
  std::vector<int> tight;
  for (int k = 0; k < town.drive.frames; ++k) {
    const double t = k * kFrameInterval_s;
    const SceneView view = scene.View(t, t);
    uint32_t blocked = 0;
    RayPacket rays;
    for (int i = 0; i < 72; ++i) {
      const int level = i / 24;
      const double angle = 2 * M_PI * i / 24, up = 0.4 + 0.7 * level;
      rays.Set(
          i % 8, (town.EyeAt(t) + Vector3d(0, 0, up - kLidarHeight_m)).cast<float>(),
          Vector3f(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0F),
          1.5F);
      if (i % 8 == 7) blocked |= view.Occluded(rays);
    }
    if (blocked != 0) tight.push_back(k);
  }
  return tight;
}

TEST(ChangesTest, WhatStandsInLeavesTheLaneFree) {
  const Town town(2.5);
  EXPECT_EQ(TightFrames(town, Scene(town.Changed(1.0))), std::vector<int>());
}

}  // namespace
}  // namespace tvl::sim
