#include "tvl/sim/kerbside.h"

#include <cmath>

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

constexpr double kParking_m = 4.55;    // middle of a parked car, from the axis
constexpr double kParkedAxis_m = 3.4;  // as near as a parked car comes to any axis
constexpr double kKerbRow_m = 5.95;    // lamps and signs
constexpr double kTreeRow_m = 6.6;

bool PlaceSmall(uint32_t prototype, const StreetSide& side, double s, double distance_m,
                double half_m, Site* site) {
  const Vector2d p = side.At(s, distance_m);
  return site->TryPlace(prototype, p, -side.Outwards(s), {p, Vector2d::UnitX(), half_m, half_m},
                        {1.9, distance_m - half_m - 0.25, true});
}

}  // namespace

void ParkCars(const StreetSide& side, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  double density = 0.5;
  for (double s = side.begin_m; s < side.end_m; s += 0.7) {
    if (rng->Uniform() < 0.03) density = rng->Uniform(0.0, 0.9);
    if (rng->Uniform() > density) {
      s += 3.0;
      continue;
    }
    const uint32_t prototype = rng->Uniform() < 0.88 ? p.car.Pick(rng) : p.van.first;
    const CarShape& shape = p.ShapeOf(prototype);
    const double middle = s + 0.5 * shape.length_m;
    const Vector2d place = side.At(middle, kParking_m + rng->Uniform(-0.08, 0.08));
    const double skew = rng->Uniform(-0.02, 0.02);
    const Vector2d t = side.axis->Tangent(middle);
    const Vector2d x = (rng->Uniform() < 0.85 ? -side.side : side.side) *
                       Vector2d(t.x() - skew * t.y(), t.y() + skew * t.x());
    const Footprint footprint{place, x, 0.5 * shape.length_m + 0.3, 0.5 * shape.width_m + 0.1};
    if (site->TryPlace(prototype, place, x, footprint, {1.7, kParkedAxis_m, true})) {
      s += shape.length_m + rng->Uniform(0.6, 1.5);
    }
  }
}

void PlantAvenue(const StreetSide& side, Rng* rng, Site* site) {
  bool has_trees = rng->Uniform() < 0.5;
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(8.5, 12.0)) {
    if (rng->Uniform() < 0.12) has_trees = !has_trees;
    if (!has_trees) continue;
    const double yaw = rng->Uniform(0.0, 6.28);
    const Vector2d p = side.At(s, kTreeRow_m);
    // Only the trunk needs room here; crowns stay 1.7 m from the lane by their size.
    site->TryPlace(site->prototypes().broadleaf.Pick(rng), p, {std::cos(yaw), std::sin(yaw)},
                   {p, Vector2d::UnitX(), 0.4, 0.4}, {4.3, kTreeRow_m - 0.9, true});
  }
}

void PutFurniture(const StreetSide& side, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  for (double s = side.begin_m + rng->Uniform(0.0, 20.0); s < side.end_m; s += 32.0) {
    PlaceSmall(p.lamp.first, side, s, kKerbRow_m, 0.15, site);
  }
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(18.0, 45.0)) {
    const Vector2d place = side.At(s, kKerbRow_m), t = side.axis->Tangent(s);
    site->TryPlace(p.sign.Pick(rng), place, -side.side * t, {place, t, 0.3, 0.4},
                   {1.9, kKerbRow_m - 0.7, true});
  }
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(8.0, 25.0)) {
    const double draw = rng->Uniform();
    const uint32_t kind = draw < 0.5 ? p.bin.first : draw < 0.8 ? p.bollard.first : p.cabinet.first;
    PlaceSmall(kind, side, s, draw < 0.5 || draw >= 0.8 ? 7.2 : kKerbRow_m, 0.4, site);
  }
}

void PutLampsAlike(const StreetSide& side, Site* site) {
  for (double s = side.begin_m; s < side.end_m; s += 26.0) {
    PlaceSmall(site->prototypes().lamp.first, side, s, kKerbRow_m, 0.15, site);
  }
}

void PutOpenRoad(const StreetSide& side, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  for (double s = side.begin_m; s < side.end_m; s += 50.0) {
    PlaceSmall(p.bollard.first, side, s, kKerbRow_m, 0.15, site);
  }
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(60.0, 160.0)) {
    PlaceSmall(rng->Uniform() < 0.5 ? p.big_tree.Pick(rng) : p.bush.Pick(rng), side, s,
               rng->Uniform(14.0, 34.0), 1.5, site);
  }
}

void PlantTreeLine(const StreetSide& side, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(3.0, 12.0)) {
    if (rng->Uniform() < 0.03) s += rng->Uniform(20.0, 90.0);  // a gap
    const uint32_t tree = rng->Uniform() < 0.7 ? p.big_tree.Pick(rng) : p.conifer.Pick(rng);
    PlaceSmall(tree, side, s, rng->Uniform(118.0, 150.0), 1.0, site);
  }
}

}  // namespace tvl::sim
