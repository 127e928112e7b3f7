#include "tvl/sim/prototypes.h"

#include <functional>

#include "tvl/sim/lorry.h"
#include "tvl/sim/plants.h"

namespace tvl::sim {
namespace {

constexpr uint64_t kPrototypeStream = 401;

}  // namespace

double Prototypes::LengthOf_m(uint32_t prototype) const {
  if (prototype < lorry.first) return ShapeOf(prototype).length_m;
  return LorryLength_m(static_cast<int>(prototype - lorry.first));
}

Prototypes BuildPrototypes(uint64_t seed) {
  Rng rng(seed, kPrototypeStream);
  Prototypes p;
  const auto add = [&p](int count, const std::function<Mesh(int)>& build) {
    const PrototypeRange range{static_cast<uint32_t>(p.meshes.size()),
                               static_cast<uint32_t>(count)};
    for (int i = 0; i < count; ++i) p.meshes.push_back(build(i));
    return range;
  };
  p.broadleaf = add(
      6, [&](int) { return BuildBroadleaf(rng.Uniform(5.0, 8.0), rng.Uniform(1.7, 2.4), &rng); });
  p.conifer = add(
      3, [&](int) { return BuildConifer(rng.Uniform(5.0, 10.0), rng.Uniform(1.2, 2.0), &rng); });
  p.big_tree = add(
      4, [&](int) { return BuildBroadleaf(rng.Uniform(9.0, 14.0), rng.Uniform(3.0, 4.2), &rng); });
  p.hedge = add(4, [&](int i) { return BuildHedge(kHedgePiece_m, 1.0 + 0.35 * i, 0.7, &rng); });
  p.bush = add(3, [&](int i) { return BuildBush(0.6 + 0.25 * i, &rng); });
  p.lamp = add(1, [](int) { return BuildLampPost(); });
  p.sign = add(3, [](int i) { return BuildTrafficSign(i); });
  p.bin = add(1, [](int) { return BuildBin(); });
  p.bollard = add(1, [](int) { return BuildBollard(); });
  p.cabinet = add(1, [](int) { return BuildCabinet(); });
  p.bench = add(1, [](int) { return BuildBench(); });
  p.fence = add(1, [](int) { return BuildPicketFence(kFencePiece_m); });
  p.wall = add(1, [](int) { return BuildGardenWall(kFencePiece_m); });
  p.car_shapes = CarShapes();
  const auto car = [&](int i) { return BuildCar(p.car_shapes[static_cast<size_t>(i)]); };
  p.car = add(4, car);
  p.van = add(2, [&](int i) { return car(4 + i); });
  p.pedestrian = add(4, [](int i) { return BuildPedestrian(1.6 + 0.08 * i, 0.33 * i); });
  p.cyclist = add(1, [](int) { return BuildCyclist(); });
  p.lorry = add(kLorryKinds, BuildLorry);
  return p;
}

}  // namespace tvl::sim
