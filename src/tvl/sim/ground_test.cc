#include "tvl/sim/ground.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/sim/scene.h"
#include "tvl/sim/tunnel.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

std::unique_ptr<Scene> SceneOf(Mesh mesh) {
  SceneDescription d;
  d.structures.push_back({std::move(mesh), Rigid3d()});
  return std::make_unique<Scene>(d);
}

// What lies straight below a point.
SceneHit Below(const Scene& scene, double x, double y, float from = 50.0F) {
  RayPacket rays;
  rays.Set(0, Vector3f(static_cast<float>(x), static_cast<float>(y), from), -Vector3f::UnitZ(),
           200.0F);
  return scene.View(0, 0).Intersect(rays)[0];
}

TEST(GroundTest, HasTheProfileOfAStreet) {
  const std::vector<Polyline> axes = {Polyline({{0, 0}, {100, 20}}).Resampled(0.5)};
  const Terrain terrain = Terrain::Rolling(1);
  const StreetProfile profile;
  const auto scene = SceneOf(BuildGround(axes, terrain, profile));
  const Vector2d t = axes[0].Tangent(50), left(-t.y(), t.x());
  const auto height_at = [&](double side) {
    const Vector2d p = axes[0].At(50) + side * left;
    return Below(*scene, p.x(), p.y()).p_world.z() - terrain.Height(p);
  };
  EXPECT_NEAR(height_at(0.0), 0.0, 0.01);
  EXPECT_NEAR(height_at(5.38), ProfileHeight(profile, 5.38), 0.01);
  EXPECT_NEAR(height_at(-5.42) - height_at(-5.38), 0.12, 0.01) << "the kerb's step";
  const Vector2d road = axes[0].At(50) + 3.0 * left, slabs = axes[0].At(50) - 6.5 * left;
  EXPECT_EQ(Below(*scene, road.x(), road.y()).material, Material::kAsphalt);
  EXPECT_EQ(Below(*scene, slabs.x(), slabs.y()).material, Material::kPavement);
  EXPECT_EQ(Below(*scene, 50, 40).material, Material::kGrass);
}

TEST(GroundTest, CrossingsAreOpen) {
  const std::vector<Polyline> axes = {Polyline({{-60, 0}, {60, 0}}).Resampled(0.5),
                                      Polyline({{0, 0}, {0, 60}}).Resampled(0.5)};
  const auto scene = SceneOf(BuildGround(axes, Terrain(), {}));
  // Into the side street along its axis: asphalt all the way, no step.
  float last = Below(*scene, 2.0, 0.0).p_world.z();
  for (double y = 0.0; y < 50.0; y += 0.25) {
    const SceneHit hit = Below(*scene, 2.0, y);
    EXPECT_EQ(hit.material, Material::kAsphalt) << y;
    EXPECT_NEAR(hit.p_world.z(), last, 0.03) << y;
    last = hit.p_world.z();
  }
}

TEST(GroundTest, HasNoHoles) {
  const std::vector<Polyline> axes = {RoundCorners({{0, 0}, {80, 0}, {80, 70}}, 9.0, 0.5),
                                      Polyline({{40, 0}, {45, -50}})};
  const auto scene = SceneOf(BuildGround(axes, Terrain::Rolling(2), {}));
  for (double x = -80.123; x < 160; x += 3.7) {
    for (double y = -100; y < 140; y += 3.3) EXPECT_TRUE(Below(*scene, x, y).hit) << x << " " << y;
  }
}

TEST(MarkingsTest, ASharedStreetIsPaintedOnce) {
  const Polyline street = Polyline({{0, 0}, {90, 0}}).Resampled(0.5);
  const Polyline again = Polyline({{0, 0.4}, {90, 0.4}}).Resampled(0.5);
  const size_t once = BuildMarkings({street}, Terrain(), {}).triangles.size();
  const size_t twice = BuildMarkings({street, again}, Terrain(), {}).triangles.size();
  EXPECT_GT(once, 50U);
  EXPECT_EQ(twice, once);
}

TEST(TunnelTest, IsASmoothTube) {
  const Polyline lane = Polyline({{0, 0}, {200, 0}}).Resampled(0.5);
  const TunnelOptions options;
  const auto scene = SceneOf(BuildTunnel(lane, 50, 150, Terrain(), options));
  const float axis_z = static_cast<float>(options.axis_height_m + options.floor_above_m);
  const SceneView view = scene->View(0, 0);
  for (float x = 60.37F; x < 140; x += 7.3F) {
    for (float angle = 0.01F; angle < 3.1F; angle += 0.17F) {
      RayPacket rays;
      const Vector3f direction(0, std::cos(angle), std::sin(angle));
      rays.Set(0, Vector3f(x, 0, axis_z), direction, 50.0F);
      const SceneHit hit = view.Intersect(rays)[0];
      ASSERT_TRUE(hit.hit);
      EXPECT_NEAR(hit.range_m, 4.0F, 0.005F) << "relief of the facets only";
      EXPECT_EQ(hit.material, Material::kTunnelWall);
      EXPECT_NEAR(hit.normal.x(), 0.0F, 1e-4F) << "nothing points along the tube";
    }
    EXPECT_EQ(Below(*scene, x, 0, 1.0F).material, Material::kAsphalt);
  }
}

}  // namespace
}  // namespace tvl::sim
