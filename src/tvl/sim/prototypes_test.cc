#include "tvl/sim/prototypes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/sim/house.h"
#include "tvl/sim/plants.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

struct Bounds {
  Vector3f low = Vector3f::Constant(1e9F), high = Vector3f::Constant(-1e9F);
};

Bounds BoundsOf(const Mesh& mesh) {
  Bounds bounds;
  for (const Vector3f& v : mesh.vertices) {
    bounds.low = bounds.low.cwiseMin(v), bounds.high = bounds.high.cwiseMax(v);
  }
  return bounds;
}

size_t Count(const Mesh& mesh, Material material) {
  return static_cast<size_t>(std::count(mesh.materials.begin(), mesh.materials.end(), material));
}

TEST(PrototypesTest, AreSoundAndReproducible) {
  const Prototypes a = BuildPrototypes(1), b = BuildPrototypes(1), c = BuildPrototypes(2);
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].vertices, b.meshes[i].vertices);
    EXPECT_FALSE(a.meshes[i].triangles.empty());
    EXPECT_EQ(a.meshes[i].triangles.size(), a.meshes[i].materials.size());
    for (const auto& t : a.meshes[i].triangles) {
      EXPECT_LT(std::max({t[0], t[1], t[2]}), a.meshes[i].vertices.size());
    }
  }
  EXPECT_NE(a.meshes[a.broadleaf.first].vertices, c.meshes[c.broadleaf.first].vertices);
}

TEST(PrototypesTest, StreetTreesLeaveRoomForTheLane) {
  const Prototypes p = BuildPrototypes(3);
  for (uint32_t i = 0; i < p.broadleaf.count; ++i) {
    const Bounds b = BoundsOf(p.meshes[p.broadleaf.first + i]);
    EXPECT_LT(std::max(b.high.head<2>().maxCoeff(), -b.low.head<2>().minCoeff()), 2.9F);
    EXPECT_GT(b.high.z(), 4.0F);
  }
}

TEST(PrototypesTest, CarsHaveTheirSize) {
  const Prototypes p = BuildPrototypes(3);
  for (uint32_t i = 0; i < p.car.count + p.van.count; ++i) {
    const CarShape& shape = p.ShapeOf(p.car.first + i);
    const Mesh& mesh = p.meshes[p.car.first + i];
    const Bounds b = BoundsOf(mesh);
    EXPECT_NEAR(b.high.x() - b.low.x(), shape.length_m, 0.02);
    EXPECT_NEAR(b.high.z(), shape.height_m, 0.02);
    EXPECT_NEAR(b.low.z(), 0.0, 0.01) << "stands on the road";
    EXPECT_LT(b.high.y() - b.low.y(), shape.width_m + 0.5) << "mirrors";
    EXPECT_GT(Count(mesh, Material::kCarGlass), 0U);
    EXPECT_GT(Count(mesh, Material::kTyre), 0U);
  }
}

TEST(PlantsTest, AreMostlyLeaves) {
  Rng rng(1);
  for (const Mesh& tree : {BuildBroadleaf(7, 2.2, &rng), BuildConifer(7, 1.5, &rng)}) {
    EXPECT_GT(Count(tree, Material::kFoliage), 3000U);
    EXPECT_GT(Count(tree, Material::kBark), 10U);
    EXPECT_LT(BoundsOf(tree).high.z(), 8.5F);
  }
  const Bounds hedge = BoundsOf(BuildHedge(2.0, 1.4, 0.7, &rng));
  EXPECT_NEAR(hedge.high.z(), 1.4F, 0.15F);
  EXPECT_NEAR(hedge.high.y() - hedge.low.y(), 0.7F, 0.3F);
}

TEST(HouseTest, FitsItsPlotAndHasRelief) {
  for (int seed = 0; seed < 20; ++seed) {
    Rng rng(static_cast<uint64_t>(seed));
    const HouseStyle style = RandomHouseStyle(12.0, 9.0, seed % 2 == 0, &rng);
    const Mesh house = BuildHouse(style, &rng);
    const Bounds b = BoundsOf(house);
    EXPECT_LT(b.high.x() - b.low.x(), 12.0F + 2.6F) << "bays and balconies stick out";
    EXPECT_GT(b.low.y(), -1.4F);
    EXPECT_GT(b.high.z(), 2.5F * static_cast<float>(style.floors));
    EXPECT_GT(Count(house, Material::kWindowGlass), 0U);
    // Panes are set back from the front.
    bool is_recessed = false;
    for (size_t i = 0; i < house.triangles.size(); ++i) {
      if (house.materials[i] != Material::kWindowGlass) continue;
      const float y = house.vertices[house.triangles[i][0]].y();
      is_recessed = is_recessed || std::abs(y - static_cast<float>(style.recess_m)) < 1e-4F;
    }
    EXPECT_TRUE(is_recessed);
  }
}

}  // namespace
}  // namespace tvl::sim
