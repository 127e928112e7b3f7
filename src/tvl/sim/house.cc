#include "tvl/sim/house.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tvl::sim {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kFoundation_m = 1.0F;  // of wall below the ground

// An upright wall: u runs along it from its start, `out` is how far a point stands before it.
struct Wall {
  Vector2f start, along, outwards;  // unit vectors
  float length_m, height_m;
  Vector3f At(float u, float out, float z) const {
    const Vector2f p = start + u * along + out * outwards;
    return {p.x(), p.y(), z};
  }
};

// A rectangle of the wall, parallel to it.
void AddPanel(const Wall& wall, float u0, float u1, float z0, float z1, float out,
              Material material, Mesh* mesh) {
  if (u1 - u0 < 1e-3F || z1 - z0 < 1e-3F) return;
  mesh->AddQuad(wall.At(u0, out, z0), wall.At(u1, out, z0), wall.At(u1, out, z1),
                wall.At(u0, out, z1), material);
}

// A box before the wall.
void AddBlock(const Wall& wall, float u0, float u1, float z0, float z1, float out,
              Material material, Mesh* mesh) {
  AddPanel(wall, u0, u1, z0, z1, out, material, mesh);
  const auto side = [&](float u) {
    mesh->AddQuad(wall.At(u, 0, z0), wall.At(u, out, z0), wall.At(u, out, z1), wall.At(u, 0, z1),
                  material);
  };
  const auto cover = [&](float z) {
    mesh->AddQuad(wall.At(u0, 0, z), wall.At(u1, 0, z), wall.At(u1, out, z), wall.At(u0, out, z),
                  material);
  };
  side(u0), side(u1), cover(z0), cover(z1);
}

// An opening with its pane set back and the reveals around it.
void AddOpening(const Wall& wall, float u0, float u1, float z0, float z1, float recess,
                Material pane, Mesh* mesh) {
  AddPanel(wall, u0, u1, z0, z1, -recess, pane, mesh);
  const Material reveal = Material::kWindowFrame;
  for (const float u : {u0, u1}) {
    mesh->AddQuad(wall.At(u, 0, z0), wall.At(u, -recess, z0), wall.At(u, -recess, z1),
                  wall.At(u, 0, z1), reveal);
  }
  for (const float z : {z0, z1}) {
    mesh->AddQuad(wall.At(u0, 0, z), wall.At(u1, 0, z), wall.At(u1, -recess, z),
                  wall.At(u0, -recess, z), reveal);
  }
}

// One field of a facade: the wall around an opening [u, z ranges inside the field].
void AddField(const Wall& wall, const HouseStyle& style, float u0, float u1, float z0, float z1,
              bool is_door, Mesh* mesh) {
  const float width = static_cast<float>(is_door ? 1.0 : style.window_width_m);
  const float height = static_cast<float>(is_door ? 2.1 : style.window_height_m);
  const float middle = 0.5F * (u0 + u1);
  const float a = middle - 0.5F * width, b = middle + 0.5F * width;
  const float low = is_door ? z0 + 0.1F : z0 + 0.85F, high = std::min(low + height, z1 - 0.15F);
  if (a < u0 + 0.1F) {  // no room for an opening
    AddPanel(wall, u0, u1, z0, z1, 0, style.facade, mesh);
    return;
  }
  AddPanel(wall, u0, a, z0, z1, 0, style.facade, mesh);
  AddPanel(wall, b, u1, z0, z1, 0, style.facade, mesh);
  AddPanel(wall, a, b, z0, low, 0, style.facade, mesh);
  AddPanel(wall, a, b, high, z1, 0, style.facade, mesh);
  AddOpening(wall, a, b, low, high, static_cast<float>(style.recess_m),
             is_door ? Material::kDoor : Material::kWindowGlass, mesh);
  if (!is_door) {
    AddBlock(wall, a - 0.08F, b + 0.08F, low - 0.07F, low, 0.11F, Material::kWindowFrame, mesh);
  }
}

void AddBalcony(const Wall& wall, float middle, float z, Mesh* mesh) {
  const float u0 = middle - 1.3F, u1 = middle + 1.3F, out = 1.2F;
  AddBlock(wall, u0, u1, z - 0.16F, z, out, Material::kConcrete, mesh);
  // Posts and two rails rather than a full parapet: the lidar sees through.
  for (float u = u0; u <= u1 + 0.01F; u += 0.325F) {
    mesh->AddBox(wall.At(u, out - 0.02F, z).array() - 0.02F,
                 wall.At(u, out - 0.02F, z + 1.0F).array() + 0.02F, Material::kMetal);
  }
  AddBlock(wall, u0, u1, z + 0.98F, z + 1.04F, out, Material::kMetal, mesh);
}

void AddBay(const Wall& wall, const HouseStyle& style, float u0, float u1, float z0, float z1,
            Mesh* mesh) {
  constexpr float kOut_m = 0.75F;
  AddBlock(wall, u0, u1, z0, z1, kOut_m, style.facade, mesh);
  for (float z = z0 + 0.8F; z + 1.4F < z1; z += static_cast<float>(style.floor_height_m)) {
    // Panes stand a little proud of the bay: cheaper than cutting it open.
    AddBlock(wall, u0 + 0.3F, u1 - 0.3F, z, z + 1.4F, kOut_m + 0.03F, Material::kWindowGlass, mesh);
  }
}

void AddFacade(const Wall& wall, const HouseStyle& style, bool is_front, Rng* rng, Mesh* mesh) {
  const auto columns = std::max(1, static_cast<int>(wall.length_m / 2.7F));
  const float field = wall.length_m / static_cast<float>(columns);
  const auto floor = static_cast<float>(style.floor_height_m);
  const int door = is_front ? static_cast<int>(rng->Integer(columns)) : -1;
  AddPanel(wall, 0, wall.length_m, -kFoundation_m, 0.0F, 0, Material::kConcrete, mesh);
  AddBlock(wall, 0, wall.length_m, -kFoundation_m, 0.35F, 0.05F, Material::kConcrete, mesh);
  for (int c = 0; c < columns; ++c) {
    const float u0 = field * static_cast<float>(c), u1 = u0 + field;
    const bool has_bay =
        is_front && c != door && style.floors > 1 && rng->Uniform() < style.bay_probability;
    const bool has_balconies = is_front && !has_bay && rng->Uniform() < style.balcony_probability;
    const bool is_blind = !is_front && rng->Uniform() < 0.4;
    for (int f = 0; f < style.floors; ++f) {
      const float z = floor * static_cast<float>(f);
      if (is_blind) {
        AddPanel(wall, u0, u1, z, z + floor, 0, style.facade, mesh);
        continue;
      }
      AddField(wall, style, u0, u1, z, z + floor, c == door && f == 0, mesh);
      if (has_balconies && f > 0 && field > 2.6F) AddBalcony(wall, 0.5F * (u0 + u1), z, mesh);
    }
    if (has_bay) {
      AddBay(wall, style, u0 + 0.15F, u1 - 0.15F, 0.4F,
             floor * static_cast<float>(style.floors) - 0.3F, mesh);
    }
  }
}

void AddGableRoof(const HouseStyle& style, float height, Rng* rng, Mesh* mesh) {
  const auto w = static_cast<float>(style.width_m), d = static_cast<float>(style.depth_m);
  const float eaves = 0.45F, slope = static_cast<float>(rng->Uniform(0.6, 1.0));
  const float x0 = -0.5F * w - 0.2F, x1 = 0.5F * w + 0.2F;
  const float ridge = height + slope * 0.5F * d, low = height - slope * eaves;
  const Vector3f a(x0, -eaves, low), b(x1, -eaves, low), c(x1, 0.5F * d, ridge),
      e(x0, 0.5F * d, ridge), f(x1, d + eaves, low), g(x0, d + eaves, low);
  mesh->AddQuad(a, b, c, e, Material::kRoof);
  mesh->AddQuad(e, c, f, g, Material::kRoof);
  for (const float x : {-0.5F * w, 0.5F * w}) {
    mesh->AddTriangle({x, 0, height}, {x, d, height}, {x, 0.5F * d, ridge - 0.02F}, style.facade);
  }
  // Gutter, and a dormer or a chimney.
  mesh->AddCylinder({x0, -eaves - 0.06F, low}, {x1, -eaves - 0.06F, low}, 0.06F, 6,
                    Material::kMetal);
  const auto x = static_cast<float>(rng->Uniform(-0.3, 0.3)) * w;
  mesh->AddBox({x - 0.35F, 0.45F * d, ridge - 1.2F}, {x + 0.35F, 0.45F * d + 0.6F, ridge + 0.9F},
               Material::kBrick);
  if (rng->Uniform() < 0.5) {
    const float y = 0.12F * d, z = height + slope * y;
    mesh->AddBox({-x - 0.9F, y, z - 0.3F}, {-x + 0.9F, 0.4F * d, z + 1.5F}, style.facade);
    mesh->AddBox({-x - 0.6F, y - 0.02F, z + 0.2F}, {-x + 0.6F, y, z + 1.2F},
                 Material::kWindowGlass);
  }
}

void AddFlatRoof(const HouseStyle& style, float height, Mesh* mesh) {
  const auto w = static_cast<float>(style.width_m), d = static_cast<float>(style.depth_m);
  constexpr float kParapet_m = 0.5F, kOut_m = 0.06F;
  mesh->AddQuad({-0.5F * w, 0, height}, {0.5F * w, 0, height}, {0.5F * w, d, height},
                {-0.5F * w, d, height}, Material::kRoof);
  const float x = 0.5F * w + kOut_m;
  mesh->AddBox({-x, -kOut_m, height - 0.1F}, {x, 0.2F, height + kParapet_m}, Material::kConcrete);
  mesh->AddBox({-x, d - 0.2F, height - 0.1F}, {x, d + kOut_m, height + kParapet_m},
               Material::kConcrete);
}

}  // namespace

HouseStyle RandomHouseStyle(double width_m, double depth_m, bool is_row_house, Rng* rng) {
  HouseStyle style;
  style.width_m = width_m, style.depth_m = depth_m;
  style.floors =
      is_row_house ? 2 + static_cast<int>(rng->Integer(3)) : 1 + static_cast<int>(rng->Integer(2));
  style.floor_height_m = rng->Uniform(2.7, 3.2);
  style.facade = rng->Uniform() < 0.6 ? Material::kPlaster : Material::kBrick;
  style.has_gable = !is_row_house || rng->Uniform() < 0.6;
  style.balcony_probability = is_row_house ? 0.2 : 0.05;
  style.bay_probability = is_row_house ? 0.15 : 0.1;
  style.window_width_m = rng->Uniform(0.9, 1.5), style.window_height_m = rng->Uniform(1.2, 1.6);
  style.recess_m = rng->Uniform(0.1, 0.22);
  return style;
}

Mesh BuildHouse(const HouseStyle& style, Rng* rng) {
  Mesh mesh;
  const auto w = static_cast<float>(style.width_m), d = static_cast<float>(style.depth_m);
  const float height = static_cast<float>(style.floor_height_m) * static_cast<float>(style.floors);
  const Wall front{{-0.5F * w, 0}, {1, 0}, {0, -1}, w, height};
  const Wall right{{0.5F * w, 0}, {0, 1}, {1, 0}, d, height};
  const Wall back{{0.5F * w, d}, {-1, 0}, {0, 1}, w, height};
  const Wall left{{-0.5F * w, d}, {0, -1}, {-1, 0}, d, height};
  AddFacade(front, style, true, rng, &mesh);
  for (const Wall& wall : {right, back, left}) AddFacade(wall, style, false, rng, &mesh);
  if (style.has_gable) {
    AddGableRoof(style, height, rng, &mesh);
  } else {
    AddFlatRoof(style, height, &mesh);
  }
  const float pipe = 0.5F * w - 0.15F;
  mesh.AddCylinder({pipe, -0.08F, 0}, {pipe, -0.08F, height}, 0.05F, 6, Material::kMetal);
  return mesh;
}

}  // namespace tvl::sim
