#include "tvl/sim/lorry.h"

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

constexpr float kHalfWidth = 1.25F;  // 2.5 m, the most that is allowed on roads
constexpr float kWheel = 0.5F;       // radius

// From the wheels to the roof, its front at x = front.
void AddCab(float front, float length, float height, Mesh* mesh) {
  const float w = kHalfWidth - 0.05F, rear = front - length, sill = 1.75F;
  mesh->AddBox({rear, -w, 0.45F}, {front, w, sill}, Material::kCarPaint);
  mesh->AddBox({rear, -w, sill}, {front - 0.9F, w, height}, Material::kCarPaint);
  mesh->AddBox({front - 0.9F, -w + 0.02F, sill}, {front - 0.08F, w - 0.02F, 2.75F},
               Material::kCarGlass);
  mesh->AddBox({front - 0.9F, -w, 2.75F}, {front - 0.15F, w, height}, Material::kCarPaint);
  mesh->AddBox({front, -w + 0.1F, 0.35F}, {front + 0.05F, w - 0.1F, 0.75F}, Material::kCarTrim);
  for (const float side : {-1.0F, 1.0F}) {  // mirrors
    const float y = side * (kHalfWidth + 0.12F);
    mesh->AddBox({front - 0.35F, y - 0.1F, 1.9F}, {front - 0.2F, y + 0.1F, 2.6F},
                 Material::kCarTrim);
  }
}

void AddAxle(float x, Mesh* mesh) {
  for (const float side : {-1.0F, 1.0F}) {
    mesh->AddCylinder({x, side * 0.85F, kWheel}, {x, side * 1.22F, kWheel}, kWheel, 14,
                      Material::kTyre);
  }
}

void AddFrame(float rear, float front, Mesh* mesh) {
  mesh->AddBox({rear, -0.45F, 0.7F}, {front, 0.45F, 1.05F}, Material::kMetal);
  mesh->AddBox({rear, -1.15F, 0.5F}, {rear + 0.12F, 1.15F, 0.75F}, Material::kCarTrim);
}

// Rails that keep people from under the load.
void AddSideGuards(float rear, float front, Mesh* mesh) {
  for (const float side : {-1.0F, 1.0F}) {
    for (const float z : {0.5F, 0.8F}) {
      mesh->AddBox({rear, side * 1.2F - 0.02F, z}, {front, side * 1.2F + 0.02F, z + 0.12F},
                   Material::kMetal);
    }
  }
}

void AddTractorAndChassis(Mesh* mesh) {
  AddCab(7.0F, 2.2F, 3.5F, mesh);
  AddFrame(-7.0F, 6.5F, mesh);
  AddSideGuards(-2.8F, 1.8F, mesh);
  for (const float x : {5.7F, 2.9F, -3.6F, -4.9F, -6.2F}) AddAxle(x, mesh);
}

Mesh BuildCurtainSider() {
  Mesh mesh;
  AddTractorAndChassis(&mesh);
  mesh.AddBox({-6.95F, -kHalfWidth, 1.1F}, {4.3F, kHalfWidth, 3.95F}, Material::kTarpaulin);
  mesh.AddBox({-7.0F, -kHalfWidth, 1.05F}, {-6.95F, kHalfWidth, 3.95F}, Material::kCarPaint);
  return mesh;
}

Mesh BuildTanker() {
  Mesh mesh;
  AddTractorAndChassis(&mesh);
  const Vector3f rear(-6.9F, 0.0F, 2.3F), front(4.2F, 0.0F, 2.3F);
  mesh.AddCylinder(rear, front, 1.2F, 28, Material::kTarpaulin);
  for (const float x : {-5.5F, -2.0F, 1.5F}) {
    mesh.AddCylinder({x, 0.0F, 2.3F}, {x + 0.08F, 0.0F, 2.3F}, 1.24F, 28, Material::kMetal);
  }
  mesh.AddBox({-6.5F, -0.35F, 3.48F}, {4.0F, 0.35F, 3.55F}, Material::kMetal);  // footway
  for (const float side : {-1.0F, 1.0F}) {
    mesh.AddCylinder({-6.0F, side * 1.1F, 1.15F}, {2.0F, side * 1.1F, 1.15F}, 0.1F, 8,
                     Material::kCarTrim);
  }
  return mesh;
}

Mesh BuildDropside() {
  Mesh mesh;
  AddCab(4.5F, 1.9F, 2.7F, &mesh);
  AddFrame(-4.5F, 4.0F, &mesh);
  AddSideGuards(-1.6F, 1.6F, &mesh);
  mesh.AddBox({-4.5F, -kHalfWidth, 1.05F}, {2.4F, kHalfWidth, 1.2F}, Material::kWood);
  mesh.AddBox({-4.5F, -kHalfWidth, 1.2F}, {2.4F, kHalfWidth, 1.85F}, Material::kCarPaint);
  for (const float x : {3.3F, -2.2F, -3.4F}) AddAxle(x, &mesh);
  return mesh;
}

}  // namespace

double LorryLength_m(int kind) { return kind == 2 ? 9.0 : 14.0; }

Mesh BuildLorry(int kind) {
  TVL_CHECK(kind >= 0 && kind < kLorryKinds) << "lorry " << kind;
  if (kind == 0) return BuildCurtainSider();
  return kind == 1 ? BuildTanker() : BuildDropside();
}

}  // namespace tvl::sim
