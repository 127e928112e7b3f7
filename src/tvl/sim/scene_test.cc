#include "tvl/sim/scene.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

// The unit square x = 0, |y| <= 0.5, |z| <= 0.5.
Mesh Square(Material material) {
  Mesh mesh;
  mesh.vertices = {{0, -0.5F, -0.5F}, {0, 0.5F, -0.5F}, {0, 0.5F, 0.5F}, {0, -0.5F, 0.5F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {material, material};
  return mesh;
}

// Goes from y = 10 to y = 20 during [0, 1] s, 5 m ahead of a structure's x.
class OneMover : public MoverSource {
 public:
  std::vector<SceneMover> Movers(double begin_s, double end_s) const override {
    return {{0, 7, Pose(begin_s), Pose(end_s)}};
  }

 private:
  static Rigid3d Pose(double t) { return Rigid3d::Translation(5.0, 10.0 + 10.0 * t, 0.0); }
};

SceneDescription Description() {
  SceneDescription d;
  d.prototypes = {Square(Material::kCarPaint)};
  d.structures = {{Square(Material::kBrick), Rigid3d::Translation(10.0, 0.0, 0.0)}};
  // Turned by 90 degrees about z: its surface looks along y.
  d.instances = {
      {0, Rigid3d(Eigen::Quaterniond(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ())),
                  Eigen::Vector3d(0.0, 4.0, 0.0))}};
  d.movers = std::make_shared<OneMover>();
  return d;
}

TEST(SceneTest, HitsAStructureAndReportsItsFrame) {
  const Scene scene(Description());
  RayPacket rays;
  rays.Set(0, Vector3f(1, 0.25F, 0.1F), Vector3f::UnitX(), 100.0F);
  rays.Set(1, Vector3f(1, 3.0F, 0.1F), Vector3f::UnitX(), 100.0F);
  rays.Set(2, Vector3f(1, 0.25F, 0.1F), Vector3f::UnitX(), 8.0F);
  const HitPacket hits = scene.View(0.0, 0.0).Intersect(rays);
  ASSERT_TRUE(hits[0].hit);
  EXPECT_FLOAT_EQ(hits[0].range_m, 9.0F);
  EXPECT_EQ(hits[0].material, Material::kBrick);
  EXPECT_TRUE(hits[0].p_world.isApprox(Vector3f(10, 0.25F, 0.1F)));
  EXPECT_TRUE(hits[0].p_object.isApprox(Vector3f(0, 0.25F, 0.1F), 1e-5F));
  EXPECT_TRUE(hits[0].normal.isApprox(Vector3f(-1, 0, 0)));
  EXPECT_FALSE(hits[1].hit) << "beside it";
  EXPECT_FALSE(hits[2].hit) << "out of range";
  EXPECT_FALSE(hits[3].hit) << "unused lane";
}

TEST(SceneTest, InstanceReportsItsOwnFrame) {
  const Scene scene(Description());
  RayPacket rays;
  rays.Set(0, Vector3f(0.25F, 0, 0.1F), Vector3f::UnitY(), 100.0F);
  const HitPacket hits = scene.View(0.0, 0.0).Intersect(rays);
  ASSERT_TRUE(hits[0].hit);
  EXPECT_NEAR(hits[0].range_m, 4.0F, 1e-5F);
  EXPECT_TRUE(hits[0].p_object.isApprox(Vector3f(0, -0.25F, 0.1F), 1e-5F));
  EXPECT_TRUE(hits[0].normal.isApprox(Vector3f(0, -1, 0), 1e-5F));
  EXPECT_TRUE(hits[0].normal_object.isApprox(Vector3f(-1, 0, 0), 1e-5F));
}

TEST(SceneTest, MoversAreWhereTheyAreWhenTheRayIsCast) {
  const Scene scene(Description());
  RayPacket rays;
  rays.Set(0, Vector3f(0, 10, 0), Vector3f::UnitX(), 100.0F, 0.0F);
  rays.Set(1, Vector3f(0, 10, 0), Vector3f::UnitX(), 100.0F, 1.0F);
  rays.Set(2, Vector3f(0, 15.1F, 0), Vector3f::UnitX(), 100.0F, 0.5F);
  const SceneView view = scene.View(0.0, 1.0);
  const HitPacket hits = view.Intersect(rays);
  EXPECT_TRUE(hits[0].hit);
  EXPECT_FALSE(hits[1].hit);
  ASSERT_TRUE(hits[2].hit);
  EXPECT_NEAR(hits[2].p_object.y(), 0.1F, 1e-4F);
  EXPECT_EQ(hits[0].object, hits[2].object);
  EXPECT_EQ(view.Occluded(rays), 0b101U);
  EXPECT_NE(hits[0].object, scene.View(0.0, 0.0).Intersect(rays)[3].object);
}

TEST(SceneTest, UnknownPrototypeThrows) {
  SceneDescription d = Description();
  d.instances[0].prototype = 3;
  EXPECT_THROW(Scene{d}, Error);
}

}  // namespace
}  // namespace tvl::sim
