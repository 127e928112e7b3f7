#include "tvl/sim/site.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCell_m = 20.0;

Vector2d Left(const Vector2d& v) { return {-v.y(), v.x()}; }

std::array<Vector2d, 4> Corners(const Footprint& f) {
  const Vector2d u = f.half_length_m * f.along, v = f.half_width_m * Left(f.along);
  return {f.centre - u - v, f.centre + u - v, f.centre + u + v, f.centre - u + v};
}

// Whether an axis of `a` separates the two.
bool Separates(const Footprint& a, const Footprint& b) {
  const Vector2d offset = b.centre - a.centre;
  const Vector2d axes[2] = {a.along, Left(a.along)};
  const double half[2] = {a.half_length_m, a.half_width_m};
  for (int i = 0; i < 2; ++i) {
    const double reach = b.half_length_m * std::abs(b.along.dot(axes[i])) +
                         b.half_width_m * std::abs(Left(b.along).dot(axes[i]));
    if (std::abs(offset.dot(axes[i])) >= half[i] + reach - 1e-9) return true;
  }
  return false;
}

std::array<int, 4> CellRange(const Footprint& f) {
  const double reach = std::hypot(f.half_length_m, f.half_width_m);
  const auto cell = [](double v) { return static_cast<int>(std::floor(v / kCell_m)); };
  return {cell(f.centre.x() - reach), cell(f.centre.x() + reach), cell(f.centre.y() - reach),
          cell(f.centre.y() + reach)};
}

}  // namespace

bool Overlap(const Footprint& a, const Footprint& b) {
  return !Separates(a, b) && !Separates(b, a);
}

Site::Site(const Route& route, const Terrain& terrain, const StreetProfile& profile,
           const Prototypes& prototypes, SceneDescription* description)
    : route_(route),
      terrain_(terrain),
      profile_(profile),
      prototypes_(prototypes),
      description_(description),
      lanes_({route.lane}, 12.0),
      axes_(route.axes, 24.0) {}

double Site::GroundHeight(const Vector2d& p) const {
  return terrain_.Height(p) + ProfileHeight(profile_, std::min(30.0, AxisDistance(p)));
}

bool Site::IsFree(const Footprint& f, const Clearance& clearance) const {
  // The outline and the middle line, every metre or so: streets are wider than the gaps.
  const int along = std::max(1, static_cast<int>(std::ceil(2 * f.half_length_m)));
  const int across = std::max(1, static_cast<int>(std::ceil(2 * f.half_width_m)));
  for (int i = 0; i <= along; ++i) {
    for (int j = 0; j <= across; ++j) {
      const Vector2d p = f.centre + (2.0 * i / along - 1.0) * f.half_length_m * f.along +
                         (2.0 * j / across - 1.0) * f.half_width_m * Left(f.along);
      if (axes_.Distance(p) < clearance.axis_m || lanes_.Distance(p) < clearance.lane_m) {
        return false;
      }
    }
  }
  const auto range = CellRange(f);
  for (int x = range[0]; x <= range[1]; ++x) {
    for (int y = range[2]; y <= range[3]; ++y) {
      const auto cell = cells_.find({x, y});
      if (cell == cells_.end()) continue;
      for (const size_t other : cell->second) {
        if (Overlap(f, taken_[other])) return false;
      }
    }
  }
  return true;
}

bool Site::TryPlace(uint32_t prototype, const Vector2d& p, const Vector2d& x_direction,
                    const Footprint& footprint, const Clearance& clearance) {
  if (!IsFree(footprint, clearance)) return false;
  description_->instances.push_back({prototype, Upright(p, x_direction)});
  if (clearance.blocks) Occupy(footprint);
  return true;
}

void Site::Build(Mesh mesh, const Vector2d& p, const Vector2d& x_direction,
                 const Footprint& footprint) {
  Rigid3d T = Upright(p, x_direction);
  // On a slope a house stands on the lowest of its corners plus a step.
  double z = T.t().z();
  for (const Vector2d& corner : Corners(footprint)) {
    z = std::max(z - 0.3, std::min(z, GroundHeight(corner) + 0.15));
  }
  T = Rigid3d(T.q(), Vector3d(T.t().x(), T.t().y(), z));
  description_->structures.push_back({std::move(mesh), T});
  Occupy(footprint);
}

void Site::Occupy(const Footprint& f) {
  const auto range = CellRange(f);
  for (int x = range[0]; x <= range[1]; ++x) {
    for (int y = range[2]; y <= range[3]; ++y) cells_[{x, y}].push_back(taken_.size());
  }
  taken_.push_back(f);
}

Rigid3d Site::Upright(const Vector2d& p, const Vector2d& x_direction) const {
  const double yaw = std::atan2(x_direction.y(), x_direction.x());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ())),
          Vector3d(p.x(), p.y(), GroundHeight(p))};
}

}  // namespace tvl::sim
