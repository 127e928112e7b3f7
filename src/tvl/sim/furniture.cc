#include "tvl/sim/furniture.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

float F(double v) { return static_cast<float>(v); }

// One cross-section of a car's upper part: half width at sill and roof.
struct Cabin {
  float front_foot, front_top, rear_top, rear_foot;  // x
  float belt, roof;                                  // z
  float half_belt, half_roof;                        // y
};

void AddCabin(const Cabin& c, Mesh* mesh) {
  const auto belt = [&](float x, float side) { return Vector3f(x, side * c.half_belt, c.belt); };
  const auto roof = [&](float x, float side) { return Vector3f(x, side * c.half_roof, c.roof); };
  mesh->AddQuad(roof(c.front_top, -1), roof(c.front_top, 1), roof(c.rear_top, 1),
                roof(c.rear_top, -1), Material::kCarPaint);
  mesh->AddQuad(belt(c.front_foot, -1), belt(c.front_foot, 1), roof(c.front_top, 1),
                roof(c.front_top, -1), Material::kCarGlass);
  mesh->AddQuad(belt(c.rear_foot, -1), belt(c.rear_foot, 1), roof(c.rear_top, 1),
                roof(c.rear_top, -1), Material::kCarGlass);
  for (const float side : {-1.0F, 1.0F}) {
    mesh->AddQuad(belt(c.front_foot, side), roof(c.front_top, side), roof(c.rear_top, side),
                  belt(c.rear_foot, side), Material::kCarGlass);
    // Pillar in the middle and the frame over the windows stand slightly proud.
    const float x = 0.5F * (c.front_top + c.rear_top);
    const auto proud = [&](Vector3f p) { return Vector3f(p.x(), p.y() + side * 0.012F, p.z()); };
    mesh->AddQuad(proud(belt(x - 0.05F, side)), proud(roof(x - 0.05F, side)),
                  proud(roof(x + 0.05F, side)), proud(belt(x + 0.05F, side)), Material::kCarPaint);
  }
}

// The part below the windows: an extruded outline with rounded front and rear.
void AddBody(const CarShape& s, Mesh* mesh) {
  const float l = F(0.5 * s.length_m), w = F(0.5 * s.width_m), belt = F(s.belt_m);
  const float hood = F(s.length_m * 0.5 - s.hood_m);
  const std::vector<Vector3f> outline = {
      {l - 0.05F, 0, 0.22F}, {l, 0, 0.45F},  {l - 0.08F, 0, 0.68F}, {hood, 0, belt},
      {-l + 0.05F, 0, belt}, {-l, 0, 0.62F}, {-l + 0.06F, 0, 0.25F}};
  const auto at = [&](const Vector3f& p, float y) { return Vector3f(p.x(), y, p.z()); };
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vector3f &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const bool is_bumper = i == 0 || i == 5;
    mesh->AddQuad(at(a, -w), at(b, -w), at(b, w), at(a, w),
                  is_bumper ? Material::kCarTrim : Material::kCarPaint);
  }
  for (const float y : {-w, w}) {
    std::vector<Vector3f> side;
    for (const Vector3f& p : outline) side.push_back(at(p, y));
    mesh->AddPolygon(side, Material::kCarPaint);
  }
}

void AddWheels(const CarShape& s, Mesh* mesh) {
  const float radius = s.is_box ? 0.36F : 0.32F, w = F(0.5 * s.width_m);
  for (const float x : {F(0.31 * s.length_m), F(-0.30 * s.length_m)}) {
    for (const float side : {-1.0F, 1.0F}) {
      mesh->AddCylinder({x, side * (w - 0.18F), radius}, {x, side * (w + 0.02F), radius}, radius,
                        12, Material::kTyre);
    }
  }
}

void AddBoxCar(const CarShape& s, Mesh* mesh) {
  const float l = F(0.5 * s.length_m), w = F(0.5 * s.width_m), h = F(s.height_m);
  const float hood = l - F(s.hood_m), belt = F(s.belt_m);
  mesh->AddBox({-l, -w, 0.3F}, {hood - 0.7F, w, h}, Material::kCarPaint);
  mesh->AddBox({hood - 0.7F, -w, 0.3F}, {l, w, belt}, Material::kCarPaint);
  const Cabin cab{l - 0.15F, hood, hood - 0.7F, hood - 0.7F, belt, std::min(h, 2.3F), w, w - 0.12F};
  AddCabin(cab, mesh);
}

}  // namespace

Mesh BuildLampPost() {
  Mesh mesh;
  mesh.AddCone({0, 0, -0.2F}, {0, 0, 6.2F}, 0.09F, 0.05F, 8, Material::kMetal);
  mesh.AddCylinder({0, 0, 6.1F}, {1.1F, 0, 6.35F}, 0.035F, 6, Material::kMetal);
  mesh.AddBox({0.9F, -0.12F, 6.28F}, {1.6F, 0.12F, 6.42F}, Material::kMetal);
  return mesh;
}

Mesh BuildTrafficSign(int kind) {
  Mesh mesh;
  mesh.AddCylinder({0, 0, -0.2F}, {0, 0, 2.9F}, 0.035F, 8, Material::kMetal);
  if (kind == 0) {
    mesh.AddCylinder({-0.05F, 0, 2.5F}, {-0.03F, 0, 2.5F}, 0.31F, 16, Material::kSign);
  } else if (kind == 1) {
    mesh.AddTriangle({-0.05F, -0.42F, 2.15F}, {-0.05F, 0.42F, 2.15F}, {-0.05F, 0, 2.9F},
                     Material::kSign);
  } else {
    mesh.AddBox({-0.06F, -0.6F, 2.1F}, {-0.03F, 0.6F, 2.75F}, Material::kSign);
  }
  return mesh;
}

Mesh BuildBin() {
  Mesh mesh;
  mesh.AddBox({-0.29F, -0.37F, 0.05F}, {0.29F, 0.37F, 0.98F}, Material::kCarTrim);
  mesh.AddBox({-0.33F, -0.40F, 0.98F}, {0.33F, 0.40F, 1.07F}, Material::kCarTrim);
  return mesh;
}

Mesh BuildBollard() {
  Mesh mesh;
  mesh.AddCylinder({0, 0, -0.2F}, {0, 0, 0.9F}, 0.08F, 10, Material::kConcrete);
  return mesh;
}

Mesh BuildCabinet() {
  Mesh mesh;
  mesh.AddBox({-0.4F, -0.2F, -0.2F}, {0.4F, 0.2F, 1.2F}, Material::kMetal);
  return mesh;
}

Mesh BuildBench() {
  Mesh mesh;
  mesh.AddBox({-0.8F, -0.22F, 0.42F}, {0.8F, 0.22F, 0.48F}, Material::kWood);
  mesh.AddBox({-0.8F, 0.2F, 0.5F}, {0.8F, 0.25F, 0.95F}, Material::kWood);
  for (const float x : {-0.7F, 0.6F}) {
    mesh.AddBox({x, -0.2F, -0.1F}, {x + 0.1F, 0.2F, 0.42F}, Material::kConcrete);
  }
  return mesh;
}

Mesh BuildPicketFence(double length_m) {
  Mesh mesh;
  const float length = F(length_m);
  for (const float z : {0.25F, 0.85F}) {
    mesh.AddBox({0, -0.02F, z}, {length, 0.02F, z + 0.08F}, Material::kWood);
  }
  for (float x = 0.05F; x < length; x += 0.17F) {
    mesh.AddBox({x, -0.035F, -0.1F}, {x + 0.08F, -0.02F, 1.05F}, Material::kWood);
  }
  return mesh;
}

Mesh BuildGardenWall(double length_m) {
  Mesh mesh;
  const float length = F(length_m);
  mesh.AddBox({0, -0.12F, -0.5F}, {length, 0.12F, 0.85F}, Material::kBrick);
  mesh.AddBox({0, -0.16F, 0.85F}, {length, 0.16F, 0.93F}, Material::kConcrete);
  return mesh;
}

std::vector<CarShape> CarShapes() {
  return {{3.7, 1.65, 1.48, 0.80, 0.15, 0.93, false}, {4.6, 1.80, 1.44, 1.15, 0.75, 0.90, false},
          {4.7, 1.80, 1.50, 1.15, 0.15, 0.92, false}, {4.5, 1.85, 1.75, 1.05, 0.15, 1.08, false},
          {5.2, 1.95, 2.25, 0.55, 0.0, 1.10, true},   {7.5, 2.30, 3.30, 0.35, 0.0, 1.50, true}};
}

Mesh BuildCar(const CarShape& s) {
  Mesh mesh;
  AddWheels(s, &mesh);
  if (s.is_box) {
    AddBoxCar(s, &mesh);
    return mesh;
  }
  AddBody(s, &mesh);
  const float l = F(0.5 * s.length_m), w = F(0.5 * s.width_m);
  const float front = l - F(s.hood_m), rear = -l + 0.06F + F(s.trunk_m);
  AddCabin(
      {front, front - 0.75F, rear + 0.45F, rear, F(s.belt_m), F(s.height_m), w - 0.03F, w - 0.22F},
      &mesh);
  for (const float side : {-1.0F, 1.0F}) {  // mirrors
    const float y = side * (w + 0.09F);
    mesh.AddBox({front - 0.42F, y - 0.09F, F(s.belt_m)},
                {front - 0.30F, y + 0.09F, F(s.belt_m) + 0.14F}, Material::kCarPaint);
  }
  return mesh;
}

Mesh BuildPedestrian(double height_m, double stride) {
  Mesh mesh;
  const float h = F(height_m), hip = 0.50F * h, shoulder = 0.82F * h;
  const float step = F(0.35 * stride);
  for (const float side : {-1.0F, 1.0F}) {
    mesh.AddCone({side * step, side * 0.09F, 0.0F}, {0, side * 0.09F, hip}, 0.06F, 0.09F, 8,
                 Material::kClothing);
    mesh.AddBox({side * step - 0.08F, side * 0.09F - 0.05F, 0.0F},
                {side * step + 0.17F, side * 0.09F + 0.05F, 0.08F}, Material::kTyre);
    mesh.AddCone({0, side * 0.22F, shoulder}, {-side * 0.7F * step, side * 0.26F, 0.46F * h}, 0.06F,
                 0.045F, 7, Material::kClothing);
  }
  mesh.AddEllipsoid({0, 0, 0.66F * h}, {0.14F, 0.21F, 0.20F * h}, 7, Material::kClothing);
  mesh.AddEllipsoid({0.02F, 0, 0.92F * h}, {0.10F, 0.085F, 0.075F * h}, 6, Material::kSkin);
  return mesh;
}

Mesh BuildCyclist() {
  Mesh mesh = BuildPedestrian(1.75, 0.4);
  for (Vector3f& v : mesh.vertices) v.z() = std::max(0.12F, v.z() + 0.12F);
  for (const float x : {-0.52F, 0.52F}) {
    mesh.AddCylinder({x, -0.02F, 0.34F}, {x, 0.02F, 0.34F}, 0.34F, 16, Material::kTyre);
  }
  mesh.AddCylinder({-0.52F, 0, 0.34F}, {0.1F, 0, 0.85F}, 0.02F, 6, Material::kMetal);
  mesh.AddCylinder({0.52F, 0, 0.34F}, {0.4F, 0, 0.95F}, 0.02F, 6, Material::kMetal);
  return mesh;
}

}  // namespace tvl::sim
