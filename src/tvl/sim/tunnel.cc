#include "tvl/sim/tunnel.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kArcs = 72;  // facets of the vault: 5 degrees each leave relief of 2 mm

// A cross-section: across (left) and up from the road at the lane.
struct Section {
  Vector3d origin;
  Vector2d left;
  Vector3f At(double across, double up) const {
    return Vector3d(origin.x() + across * left.x(), origin.y() + across * left.y(), origin.z() + up)
        .cast<float>();
  }
};

Section SectionAt(const Polyline& lane, double s, const Terrain& terrain, const TunnelOptions& o) {
  const Vector2d p = lane.At(s), t = lane.Tangent(s);
  return {Vector3d(p.x(), p.y(), terrain.Height(p) + o.floor_above_m), Vector2d(-t.y(), t.x())};
}

struct Vault {
  double begin_rad, end_rad;  // of the arc, from straight left over the top to straight right
  double radius_m, height_m;
  Vector3f At(const Section& section, int i) const {
    const double angle = begin_rad + (end_rad - begin_rad) * i / kArcs;
    return section.At(radius_m * std::cos(angle), height_m + radius_m * std::sin(angle));
  }
};

// A wall around the mouth.
void AddPortal(const Section& section, const Vault& vault, Mesh* mesh) {
  constexpr double kHalf_m = 9.0, kTop_m = 8.0;
  const auto outer = [&](int i) {
    const double angle = vault.begin_rad + (vault.end_rad - vault.begin_rad) * i / kArcs;
    const double scale = std::min(kHalf_m / std::max(1e-6, std::abs(std::cos(angle))),
                                  (kTop_m - vault.height_m) / std::max(1e-6, std::sin(angle)));
    return section.At(scale * std::cos(angle), vault.height_m + scale * std::sin(angle));
  };
  for (int i = 0; i < kArcs; ++i) {
    mesh->AddQuad(vault.At(section, i), vault.At(section, i + 1), outer(i + 1), outer(i),
                  Material::kConcrete);
  }
}

}  // namespace

Mesh BuildTunnel(const Polyline& lane, double begin_m, double end_m, const Terrain& terrain,
                 const TunnelOptions& o) {
  Mesh mesh;
  const double low = -std::asin(o.axis_height_m / o.radius_m);
  const Vault vault{low, kPi - low, o.radius_m, o.axis_height_m};
  const double half_floor = o.radius_m * std::cos(low);
  constexpr double kStep_m = 1.0;
  const auto steps = static_cast<int>(std::max(1.0, std::round((end_m - begin_m) / kStep_m)));
  for (int k = 0; k < steps; ++k) {
    const Section a = SectionAt(lane, begin_m + (end_m - begin_m) * k / steps, terrain, o);
    const Section b = SectionAt(lane, begin_m + (end_m - begin_m) * (k + 1) / steps, terrain, o);
    for (int i = 0; i < kArcs; ++i) {
      mesh.AddQuad(vault.At(a, i), vault.At(a, i + 1), vault.At(b, i + 1), vault.At(b, i),
                   Material::kTunnelWall);
    }
    mesh.AddQuad(a.At(-half_floor, 0), a.At(half_floor, 0), b.At(half_floor, 0),
                 b.At(-half_floor, 0), Material::kAsphalt);
  }
  AddPortal(SectionAt(lane, begin_m, terrain, o), vault, &mesh);
  AddPortal(SectionAt(lane, end_m, terrain, o), vault, &mesh);
  return mesh;
}

}  // namespace tvl::sim
