#include "tvl/sim/town.h"

#include <algorithm>

#include "tvl/sim/kerbside.h"
#include "tvl/sim/plots.h"
#include "tvl/sim/site.h"
#include "tvl/sim/tunnel.h"

namespace tvl::sim {
namespace {

constexpr uint64_t kTownStream = 501;

using Span = std::pair<double, double>;

// [begin, end) without the given stretches.
std::vector<Span> Without(Span whole, std::vector<Span> holes) {
  std::sort(holes.begin(), holes.end());
  std::vector<Span> rest;
  double from = whole.first;
  for (const Span& hole : holes) {
    if (hole.first > from) rest.emplace_back(from, std::min(hole.first, whole.second));
    from = std::max(from, hole.second);
  }
  if (from < whole.second) rest.emplace_back(from, whole.second);
  return rest;
}

class TownBuilder {
 public:
  TownBuilder(const Route& route, const TownOptions& options, Site* site)
      : route_(route), options_(options), site_(site) {}

  void Fill() {
    // Plots first, all over the town: later streets must not find theirs taken by backyards.
    Sides([&](const StreetSide& side, Rng* rng) {
      if (options_.is_repeating) {
        FillPlotsAlike(side, site_);
      } else {
        FillPlots(side, rng, site_);
      }
    });
    Sides([&](const StreetSide& side, Rng* rng) {
      if (options_.is_repeating) {
        PutLampsAlike(side, site_);
        return;
      }
      PutFurniture(side, rng, site_);
      PlantAvenue(side, rng, site_);
      if (options_.has_parked_cars) ParkCars(side, rng, site_);
    });
    Sides([&](const StreetSide& side, Rng* rng) {
      if (!options_.is_repeating) FillBackyards(side, rng, site_);
    });
    if (!options_.has_street_ends) return;
    Rng rng(options_.seed, kTownStream + 7);
    for (const Polyline& axis : route_.axes) {
      CloseStreetEnd(axis, false, &rng, site_);
      if (&axis == &route_.axes.front()) CloseStreetEnd(axis, true, &rng, site_);
    }
  }

  // Stretches left open.
  void FillOpen() {
    Rng rng(options_.seed, kTownStream + 8);
    const double offset = AxisOffset();
    std::vector<Span> spans;
    if (options_.is_open) spans = {{0.0, route_.axes[0].length_m()}};
    for (const Span& open : options_.open_m) {
      spans.emplace_back(open.first + offset, open.second + offset);
    }
    for (const Span& span : spans) {
      for (const double side : {1.0, -1.0}) {
        PutOpenRoad({&route_.axes[0], side, span.first, span.second, options_.setback_m}, &rng,
                    site_);
      }
    }
  }

  void FillBare() {
    if (options_.bare_m.empty()) return;
    Rng rng(options_.seed, kTownStream + 9);
    for (const double side : {1.0, -1.0}) {
      PlantTreeLine({&route_.axes[0], side, 0.0, route_.axes[0].length_m(), 0.0}, &rng, site_);
    }
  }

 private:
  // Axis 0 begins this much before the lane.
  double AxisOffset() const { return 0.5 * (route_.axes[0].length_m() - route_.lane.length_m()); }

  template <typename Body>
  void Sides(const Body& body) {
    Rng rng(options_.seed, kTownStream + stream_++);
    std::vector<Span> holes;
    const double offset = AxisOffset();
    for (const std::vector<Span>* spans : {&options_.open_m, &options_.bare_m}) {
      for (const Span& span : *spans) {
        holes.emplace_back(span.first + offset, span.second + offset);
      }
    }
    if (route_.tunnel_end_m > route_.tunnel_begin_m) {
      holes.emplace_back(route_.tunnel_begin_m + offset - 2.0, route_.tunnel_end_m + offset + 2.0);
    }
    for (const Polyline& axis : route_.axes) {
      const bool is_driven = &axis == &route_.axes.front();
      const Span whole(is_driven ? 0.0 : 8.0, axis.length_m());
      for (const Span& span : Without(whole, is_driven ? holes : std::vector<Span>())) {
        for (const double side : {1.0, -1.0}) {
          body(StreetSide{&axis, side, span.first, span.second, options_.setback_m}, &rng);
        }
      }
    }
  }

  const Route& route_;
  const TownOptions& options_;
  Site* site_;
  uint64_t stream_ = 0;
};

}  // namespace

SceneDescription BuildTown(const Route& route, const Terrain& terrain, const Prototypes& prototypes,
                           const TownOptions& options) {
  SceneDescription description;
  description.prototypes = prototypes.meshes;
  const StreetProfile& profile = options.profile;
  description.structures.push_back({BuildGround(route.axes, terrain, profile), Rigid3d()});
  description.structures.push_back({BuildMarkings(route.axes, terrain, profile), Rigid3d()});
  Site site(route, terrain, profile, prototypes, &description);
  TownBuilder builder(route, options, &site);
  if (!options.is_open) builder.Fill();
  builder.FillOpen();
  builder.FillBare();
  if (route.tunnel_end_m > route.tunnel_begin_m) {
    description.structures.push_back(
        {BuildTunnel(route.lane, route.tunnel_begin_m, route.tunnel_end_m, terrain), Rigid3d()});
  }
  return description;
}

}  // namespace tvl::sim
