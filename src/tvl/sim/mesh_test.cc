#include "tvl/sim/mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

double Area(const Mesh& mesh) {
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

TEST(MeshTest, PolygonsAreFans) {
  Mesh mesh;
  mesh.AddPolygon({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}}, Material::kRoof);
  EXPECT_EQ(mesh.triangles.size(), 3U);
  EXPECT_EQ(mesh.materials.size(), 3U);
  EXPECT_DOUBLE_EQ(Area(mesh), 3.0);
}

TEST(MeshTest, BoxHasSixSides) {
  Mesh mesh;
  mesh.AddBox({0, 0, 0}, {1, 2, 3}, Material::kConcrete);
  EXPECT_NEAR(Area(mesh), 2.0 * (1 * 2 + 1 * 3 + 2 * 3), 1e-5);
}

TEST(MeshTest, RoundShapesApproachTheirArea) {
  Mesh cylinder;
  cylinder.AddCylinder({0, 0, 0}, {0, 0, 2}, 0.5F, 200, Material::kMetal);
  EXPECT_NEAR(Area(cylinder), 2 * kPi * 0.5 * 2 + 2 * kPi * 0.25, 0.01);
  Mesh sphere;
  sphere.AddEllipsoid({1, 2, 3}, {2, 2, 2}, 60, Material::kClothing);
  EXPECT_NEAR(Area(sphere), 4 * kPi * 4, 0.1);
}

TEST(MeshTest, CardsAreCentred) {
  Mesh mesh;
  mesh.AddCard({1, 1, 1}, {0.5F, 0, 0}, {0, 0, 0.25F}, Material::kFoliage);
  Vector3f mean = Vector3f::Zero();
  for (const Vector3f& v : mesh.vertices) mean += v / 4.0F;
  EXPECT_TRUE(mean.isApprox(Vector3f(1, 1, 1)));
  EXPECT_NEAR(Area(mesh), 0.5, 1e-6);
}

TEST(MaterialTest, SurfacesAreWithinBounds) {
  for (size_t i = 0; i < kMaterialCount; ++i) {
    const auto material = static_cast<Material>(i);
    const LidarSurface surface = LidarSurfaceOf(material);
    EXPECT_GT(surface.reflectivity, 0.0F) << ToString(material);
    EXPECT_LE(surface.reflectivity, 1.0F) << ToString(material);
    EXPECT_LT(surface.mirror, 1.0F) << ToString(material);
    EXPECT_STRNE(ToString(material), "");
  }
}

}  // namespace
}  // namespace tvl::sim
