#include "tvl/sim/texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

const TownTextures& Town() {
  static const TownTextures textures({7, false});
  return textures;
}

SurfacePoint Wall(Material material, float x, float z, float footprint_m) {
  SurfacePoint at;
  at.material = material;
  at.object = 5;
  at.p_object = {x, 0.0F, z};
  at.normal_object = {0.0F, -1.0F, 0.0F};
  at.major_m = {footprint_m, 0.0F, 0.0F};
  at.minor_m = footprint_m;
  return at;
}

// Mean and standard deviation of the albedo over a wall.
struct Spread {
  double mean = 0.0, sigma = 0.0;
};

Spread SpreadOf(Material material, float footprint_m) {
  Rng rng(11);
  double sum = 0.0;
  double sum_sq = 0.0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const auto x = static_cast<float>(rng.Uniform(-20.0, 20.0));
    const auto z = static_cast<float>(rng.Uniform(0.6, 6.0));
    const double albedo = Town().Albedo(Wall(material, x, z, footprint_m));
    EXPECT_GE(albedo, 0.0);
    EXPECT_LE(albedo, 1.6);
    sum += albedo;
    sum_sq += albedo * albedo;
  }
  const double mean = sum / kSamples;
  return {mean, std::sqrt(std::max(0.0, sum_sq / kSamples - mean * mean))};
}

TEST(TownTextures, EveryMaterialHasTextureAndFadesWithDistance) {
  for (size_t i = 0; i < kMaterialCount; ++i) {
    const auto material = static_cast<Material>(i);
    if (material == Material::kTunnelFixture) continue;
    SCOPED_TRACE(ToString(material));
    const Spread near = SpreadOf(material, 0.005F);
    const Spread far = SpreadOf(material, 0.8F);
    EXPECT_GT(near.sigma, 0.03 * near.mean);
    EXPECT_LT(far.sigma, 0.75 * near.sigma + 0.001);
  }
}

TEST(TownTextures, FarSurfacesKeepTheirBrightness) {
  for (const Material material : {Material::kPlaster, Material::kBrick, Material::kAsphalt,
                                  Material::kGrass, Material::kWindowGlass}) {
    SCOPED_TRACE(ToString(material));
    EXPECT_NEAR(SpreadOf(material, 0.6F).mean / SpreadOf(material, 0.005F).mean, 1.0, 0.15);
  }
}

TEST(TownTextures, IsAFunctionOfPlaceObjectAndSeed) {
  const TownTextures same({7, false});
  const TownTextures other({8, false});
  int differ_seed = 0;
  int differ_object = 0;
  for (int i = 0; i < 100; ++i) {
    SurfacePoint at = Wall(Material::kPlaster, 0.37F * static_cast<float>(i), 2.0F, 0.01F);
    const float albedo = Town().Albedo(at);
    EXPECT_EQ(albedo, same.Albedo(at));
    differ_seed += std::abs(albedo - other.Albedo(at)) > 0.01F;
    at.object = 6;
    differ_object += std::abs(albedo - Town().Albedo(at)) > 0.01F;
  }
  EXPECT_GT(differ_seed, 80);
  EXPECT_GT(differ_object, 80);
}

TEST(TownTextures, HousesCanBeMadeAlikeWhileCarsStayThemselves) {
  const TownTextures alike({7, true});
  SurfacePoint house = Wall(Material::kBrick, 1.3F, 2.0F, 0.01F);
  SurfacePoint car = Wall(Material::kCarPaint, 0.3F, 0.7F, 0.01F);
  int cars_differ = 0;
  const float first_house = alike.Albedo(house);
  const float first_car = alike.Albedo(car);
  for (uint32_t object = 10; object < 30; ++object) {
    house.object = car.object = object;
    EXPECT_EQ(alike.Albedo(house), first_house);
    cars_differ += alike.Albedo(car) != first_car;
  }
  EXPECT_GT(cars_differ, 5);
}

TEST(TownTextures, ChangesLittleOverAHundredthOfThePixel) {
  for (const Material material : {Material::kPlaster, Material::kAsphalt, Material::kTunnelWall,
                                  Material::kRoadMarking, Material::kWood}) {
    SCOPED_TRACE(ToString(material));
    for (int i = 0; i < 300; ++i) {
      const float x = 0.0731F * static_cast<float>(i);
      const float a = Town().Albedo(Wall(material, x, 2.0F, 0.02F));
      const float b = Town().Albedo(Wall(material, x + 0.0002F, 2.0F, 0.02F));
      EXPECT_NEAR(a, b, 0.04F);
    }
  }
}

}  // namespace
}  // namespace tvl::sim
