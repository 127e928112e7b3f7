#include "tvl/sim/lighting.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

const Eigen::Vector3f kDown(0.0F, 0.6F, -0.8F);

SceneHit Ground(Material material) {
  SceneHit hit;
  hit.hit = true;
  hit.material = material;
  hit.normal = hit.normal_object = Eigen::Vector3f::UnitZ();
  return hit;
}

TEST(Lighting, ShadowsAreSeveralTimesDarkerThanSunlight) {
  const Lighting lighting({});
  const SceneHit hit = Ground(Material::kAsphalt);
  EXPECT_TRUE(lighting.FacesSun(hit));
  const float sunlit = lighting.Surface(hit, kDown, 0.3F, true);
  const float shaded = lighting.Surface(hit, kDown, 0.3F, false);
  EXPECT_GT(sunlit, 3.0F * shaded);
  EXPECT_GT(shaded, 0.05F);
}

TEST(Lighting, SurfacesTurnedAwayGetNoSunButLeavesLetItThrough) {
  const Lighting lighting({});
  SceneHit hit = Ground(Material::kAsphalt);
  hit.normal = -lighting.to_sun();
  EXPECT_FALSE(lighting.FacesSun(hit));
  EXPECT_EQ(lighting.Surface(hit, kDown, 0.3F, true), lighting.Surface(hit, kDown, 0.3F, false));
  hit.material = Material::kFoliage;
  EXPECT_TRUE(lighting.FacesSun(hit));
  EXPECT_GT(lighting.Surface(hit, kDown, 0.3F, true), lighting.Surface(hit, kDown, 0.3F, false));
}

TEST(Lighting, SkyOutshinesWhiteAtTheHorizon) {
  const Lighting lighting({});
  const TownTextures textures({});
  EXPECT_GT(lighting.Sky(Eigen::Vector3f::UnitX(), textures), 0.9F);
  EXPECT_GT(lighting.Sky(Eigen::Vector3f::UnitX(), textures),
            lighting.Sky(Eigen::Vector3f::UnitZ(), textures));
}

TEST(Lighting, RefusesASunBelowTheHorizon) {
  LightingOptions options;
  options.sun_elevation_rad = -0.1;
  EXPECT_THROW(Lighting{options}, InputError);
}

}  // namespace
}  // namespace tvl::sim
