#include "tvl/sim/plots.h"

#include <algorithm>
#include <cmath>

#include "tvl/sim/house.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

constexpr double kRowFront_m = 8.1;    // facades stand behind the pavement
constexpr double kGardenEdge_m = 8.0;  // hedges and fences

// Builds a house whose front is `front_m` from the axis, over [s, s + width]. False: no room.
bool TryHouse(const StreetSide& side, double s, double front_m, const HouseStyle& style, Rng* rng,
              Site* site) {
  const Vector2d a = side.At(s, front_m), b = side.At(s + style.width_m, front_m);
  // To the right as seen from the street.
  const Vector2d x = side.side * (b - a).normalized();
  const Vector2d back(-x.y(), x.x());
  const Vector2d front = 0.5 * (a + b);
  const Footprint footprint{front + 0.5 * style.depth_m * back, x, 0.5 * style.width_m,
                            0.5 * style.depth_m};
  Clearance clearance;
  clearance.axis_m = std::min(front_m, kRowFront_m) - 0.3;
  clearance.lane_m = 4.0;
  if (!site->IsFree(footprint, clearance)) return false;
  site->Build(BuildHouse(style, rng), front, x, footprint);
  return true;
}

// Pieces of hedge, fence or wall along [begin, end], with a gap for the drive.
void EdgeGarden(const StreetSide& side, double begin, double end, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  const double draw = rng->Uniform();
  const uint32_t prototype = draw < 0.5    ? p.hedge.Pick(rng)
                             : draw < 0.75 ? p.fence.first
                                           : p.wall.first;
  const double gap = rng->Uniform(begin, std::max(begin + 0.1, end - 3.0));
  for (double s = begin; s + kHedgePiece_m <= end; s += kHedgePiece_m) {
    if (s + kHedgePiece_m > gap && s < gap + 3.0) continue;
    const Vector2d from = side.At(s, kGardenEdge_m), to = side.At(s + kHedgePiece_m, kGardenEdge_m);
    const Vector2d x = (to - from).normalized();
    const Footprint footprint{from + 0.5 * kHedgePiece_m * x, x, 0.5 * kHedgePiece_m - 0.05, 0.35};
    site->TryPlace(prototype, from, x, footprint, {1.9, kGardenEdge_m - 0.6, true});
  }
}

bool TryTree(const PrototypeRange& kind, const Vector2d& p, double crown_m, double axis_m, Rng* rng,
             Site* site) {
  const Footprint footprint{p, Vector2d::UnitX(), 0.5 * crown_m, 0.5 * crown_m};
  const double yaw = rng->Uniform(0.0, 6.28);
  return site->TryPlace(kind.Pick(rng), p, {std::cos(yaw), std::sin(yaw)}, footprint,
                        {1.9 + 0.5 * crown_m, axis_m, true});
}

double FillRow(const StreetSide& side, double s, double end, Rng* rng, Site* site) {
  const double front = kRowFront_m + rng->Uniform(0.0, 1.5), depth = rng->Uniform(9.0, 12.0);
  while (s < end) {
    const double width = rng->Uniform(7.0, 15.0);
    const HouseStyle style = RandomHouseStyle(width, depth, true, rng);
    if (!TryHouse(side, s, front + rng->Uniform(0.0, 0.4), style, rng, site)) {
      s += 2.0;
      continue;
    }
    s += width + 0.05 + (rng->Uniform() < 0.2 ? rng->Uniform(2.5, 5.0) : 0.0);
  }
  return s;
}

double FillDetached(const StreetSide& side, double s, double end, Rng* rng, Site* site) {
  while (s < end) {
    const double width = rng->Uniform(8.0, 14.0), gap = rng->Uniform(3.0, 8.0);
    const double front = rng->Uniform(10.5, 15.0);
    const HouseStyle style = RandomHouseStyle(width, rng->Uniform(8.0, 11.0), false, rng);
    if (!TryHouse(side, s + 0.5 * gap, front, style, rng, site)) {
      s += 2.0;
      continue;
    }
    EdgeGarden(side, s, s + width + gap, rng, site);
    const PrototypeRange& kind =
        rng->Uniform() < 0.6 ? site->prototypes().broadleaf : site->prototypes().conifer;
    TryTree(kind, side.At(s + rng->Uniform(0.0, 2.0), kGardenEdge_m + 2.4), 3.0, 8.0, rng, site);
    for (int i = 0; i < 2; ++i) {
      TryTree(site->prototypes().bush,
              side.At(s + rng->Uniform(0.0, width), rng->Uniform(kGardenEdge_m + 1.0, front - 1.0)),
              1.2, 8.0, rng, site);
    }
    s += width + gap;
  }
  return s;
}

double FillPark(const StreetSide& side, double s, double end, Rng* rng, Site* site) {
  const bool has_hedge = rng->Uniform() < 0.6;
  if (has_hedge) EdgeGarden(side, s, end, rng, site);
  for (; s < end; s += rng->Uniform(2.5, 5.0)) {
    const double distance = rng->Uniform(kGardenEdge_m + 1.5, 26.0);
    const Prototypes& p = site->prototypes();
    const double draw = rng->Uniform();
    if (draw < 0.55) {
      TryTree(p.big_tree, side.At(s, std::max(12.0, distance)), 4.0, 9.0, rng, site);
    } else if (draw < 0.8) {
      TryTree(p.bush, side.At(s, distance), 1.2, 8.0, rng, site);
    } else if (draw < 0.9) {
      const Vector2d place = side.At(s, kGardenEdge_m + 1.5), x = -side.axis->Tangent(s);
      site->TryPlace(p.bench.first, place, side.side * x, {place, x, 0.9, 0.4}, {1.9, 8.0, true});
    }
  }
  return s;
}

}  // namespace

Vector2d StreetSide::Outwards(double s_m) const {
  const Vector2d t = axis->Tangent(s_m);
  return side * Vector2d(-t.y(), t.x());
}

Vector2d StreetSide::At(double s_m, double distance_m) const {
  return axis->At(s_m) + (setback_m + distance_m) * Outwards(s_m);
}

void FillPlots(const StreetSide& side, Rng* rng, Site* site) {
  for (double s = side.begin_m; s < side.end_m;) {
    const double end = std::min(side.end_m, s + rng->Uniform(50.0, 110.0));
    const double draw = rng->Uniform();
    if (draw < 0.45) {
      s = FillRow(side, s, end, rng, site);
    } else if (draw < 0.85) {
      s = FillDetached(side, s, end, rng, site);
    } else {
      s = FillPark(side, s, end, rng, site);
    }
  }
}

void FillPlotsAlike(const StreetSide& side, Site* site) {
  constexpr double kWidth_m = 9.0, kPeriod_m = 13.0, kFront_m = 11.0;
  HouseStyle style;
  style.width_m = kWidth_m, style.depth_m = 9.0;
  for (double s = side.begin_m; s + kWidth_m < side.end_m; s += kPeriod_m) {
    Rng same(1);  // every house the same
    TryHouse(side, s, kFront_m, style, &same, site);
    for (double u = 0.0; u < 8.0; u += kFencePiece_m) {
      const Vector2d from = side.At(s + u, kGardenEdge_m);
      const Vector2d x = (side.At(s + u + kFencePiece_m, kGardenEdge_m) - from).normalized();
      site->TryPlace(site->prototypes().fence.first, from, x,
                     {from + 0.5 * kFencePiece_m * x, x, 0.9, 0.2}, {1.9, 7.0, true});
    }
  }
}

void FillBackyards(const StreetSide& side, Rng* rng, Site* site) {
  const Prototypes& p = site->prototypes();
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(3.0, 6.0)) {
    const Vector2d place = side.At(s, rng->Uniform(19.0, 34.0));
    const double draw = rng->Uniform();
    const PrototypeRange& kind = draw < 0.5 ? p.big_tree : draw < 0.75 ? p.conifer : p.bush;
    TryTree(kind, place, draw < 0.5 ? 4.0 : 2.0, 12.0, rng, site);
  }
  for (double s = side.begin_m; s < side.end_m; s += rng->Uniform(12.0, 30.0)) {
    const HouseStyle style =
        RandomHouseStyle(rng->Uniform(9.0, 16.0), 9.0, rng->Uniform() < 0.5, rng);
    TryHouse(side, s, rng->Uniform(33.0, 45.0), style, rng, site);
  }
}

void CloseStreetEnd(const Polyline& axis, bool at_begin, Rng* rng, Site* site) {
  const double s = at_begin ? 0.0 : axis.length_m();
  const Vector2d outwards = (at_begin ? -1.0 : 1.0) * axis.Tangent(s);
  const Vector2d right(outwards.y(), -outwards.x());
  const HouseStyle style = RandomHouseStyle(rng->Uniform(14.0, 20.0), 10.0, true, rng);
  const Vector2d front = axis.At(s) + 9.0 * outwards;
  const Footprint footprint{front + 0.5 * style.depth_m * outwards, right, 0.5 * style.width_m,
                            0.5 * style.depth_m};
  if (site->IsFree(footprint, {4.0, 8.0, true})) {
    site->Build(BuildHouse(style, rng), front, right, footprint);
  }
}

}  // namespace tvl::sim
