#include "tvl/sim/plants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

float Draw(Rng* rng, double low, double high) {
  return static_cast<float>(rng->Uniform(low, high));
}

Vector3f RandomUnit(Rng* rng) {
  const double z = rng->Uniform(-1.0, 1.0), angle = rng->Uniform(0.0, 2.0 * kPi);
  const double r = std::sqrt(1.0 - z * z);
  return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z).cast<float>();
}

// A leaf (or a twig of leaves) of random direction.
void AddLeaf(const Vector3f& centre, float half_size_m, Rng* rng, Mesh* mesh) {
  const Vector3f u = RandomUnit(rng);
  const Vector3f v = u.cross(RandomUnit(rng)).normalized();
  mesh->AddCard(centre, half_size_m * u, 0.6F * half_size_m * v, Material::kFoliage);
}

// Leaves in a ball, denser towards its skin.
void AddClump(const Vector3f& centre, const Vector3f& radii_m, int leaves, Rng* rng, Mesh* mesh) {
  for (int i = 0; i < leaves; ++i) {
    const float r = std::pow(static_cast<float>(rng->Uniform()), 0.22F);
    AddLeaf(centre + r * radii_m.cwiseProduct(RandomUnit(rng)), Draw(rng, 0.09, 0.17), rng, mesh);
  }
}

}  // namespace

Mesh BuildBroadleaf(double height_m, double radius_m, Rng* rng) {
  Mesh mesh;
  const auto height = static_cast<float>(height_m), radius = static_cast<float>(radius_m);
  const float fork = std::max(2.0F, 0.35F * height);
  const float girth = 0.02F * height + 0.05F;
  const Vector3f lean(Draw(rng, -0.15, 0.15), Draw(rng, -0.15, 0.15), fork);
  mesh.AddCone({0, 0, -0.3F}, lean, 1.3F * girth, 0.8F * girth, 8, Material::kBark);
  const Vector3f crown(lean.x(), lean.y(), 0.5F * (fork + height) + 0.2F);
  const float half_height = 0.5F * (height - fork);
  constexpr int kClumps = 11, kLeavesEach = 230;
  for (int i = 0; i < kClumps; ++i) {
    const Vector3f offset =
        0.62F * Vector3f(radius, radius, half_height).cwiseProduct(RandomUnit(rng));
    const Vector3f centre = crown + offset;
    const float size = Draw(rng, 0.32, 0.42);
    Vector3f radii = size * Vector3f(radius, radius, half_height);
    radii.z() = std::min(radii.z(), centre.z() - 2.2F);
    if (radii.z() < 0.3F) continue;
    mesh.AddCone(lean, centre, 0.45F * girth, 0.1F * girth, 5, Material::kBark);
    AddClump(centre, radii, kLeavesEach, rng, &mesh);
  }
  return mesh;
}

Mesh BuildConifer(double height_m, double radius_m, Rng* rng) {
  Mesh mesh;
  const auto height = static_cast<float>(height_m), radius = static_cast<float>(radius_m);
  mesh.AddCone({0, 0, -0.3F}, {0, 0, 0.95F * height}, 0.02F * height + 0.05F, 0.02F, 7,
               Material::kBark);
  constexpr int kLeaves = 2600;
  for (int i = 0; i < kLeaves; ++i) {
    const float share = 1.0F - std::sqrt(static_cast<float>(rng->Uniform()));  // towards the top
    const float z = 0.8F + share * (height - 0.8F);
    // Whorls: branches in storeys.
    const float storey = 0.75F + 0.25F * std::sin(9.0F * z);
    const float r =
        radius * (1.0F - share) * storey * std::sqrt(static_cast<float>(rng->Uniform(0.15, 1.0)));
    const float angle = Draw(rng, 0.0, 2.0 * kPi);
    AddLeaf({r * std::cos(angle), r * std::sin(angle), z - 0.25F * r}, Draw(rng, 0.08, 0.15), rng,
            &mesh);
  }
  return mesh;
}

Mesh BuildHedge(double length_m, double height_m, double thickness_m, Rng* rng) {
  Mesh mesh;
  const auto length = static_cast<float>(length_m), height = static_cast<float>(height_m);
  const auto half = static_cast<float>(0.5 * thickness_m);
  constexpr float kSkin_m = 0.14F;
  mesh.AddBox({0, -half + kSkin_m, -0.3F}, {length, half - kSkin_m, height - kSkin_m},
              Material::kFoliage);
  const auto leaves = static_cast<int>(length * (2.0F * height + 2.0F * half) * 85.0F);
  for (int i = 0; i < leaves; ++i) {
    const float x = Draw(rng, 0.0, length_m);
    const float around = Draw(rng, 0.0, 2.0 * height_m + thickness_m);
    const float depth = Draw(rng, -0.03, 0.16);
    Vector3f p;
    if (around < height) {
      p = {x, -half + depth, around};
    } else if (around < 2.0F * height) {
      p = {x, half - depth, around - height};
    } else {
      p = {x, around - 2.0F * height - half, height - depth};
    }
    AddLeaf(p, Draw(rng, 0.05, 0.10), rng, &mesh);
  }
  return mesh;
}

Mesh BuildBush(double radius_m, Rng* rng) {
  Mesh mesh;
  const auto r = static_cast<float>(radius_m);
  for (int i = 0; i < 4; ++i) {
    const Vector3f centre(Draw(rng, -0.4, 0.4) * r, Draw(rng, -0.4, 0.4) * r, 0.65F * r);
    AddClump(centre, Vector3f(0.6F, 0.6F, 0.6F) * r, 160, rng, &mesh);
  }
  return mesh;
}

}  // namespace tvl::sim
