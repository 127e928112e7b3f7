#include "tvl/sim/lighting.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

// Leaves let light through: they also shine when lit from behind.
constexpr float kLeafTransmission = 0.45F;

// Share of the surroundings a polished surface mirrors.
float Gloss(Material material) {
  switch (material) {
    case Material::kWindowGlass:
      return 0.16F;
    case Material::kCarGlass:
      return 0.14F;
    case Material::kCarPaint:
      return 0.07F;
    default:
      return 0.0F;
  }
}

}  // namespace

void LightingOptions::Check() const {
  TVL_CHECK_INPUT(sun_elevation_rad > 0.0 && sun_elevation_rad < 1.58)
      << "sim lighting: sun_elevation_rad = " << sun_elevation_rad << " is not in (0, pi/2]";
  TVL_CHECK_INPUT(sun >= 0.0 && ambient >= 0.0 && sky >= 0.0)
      << "sim lighting: sun, ambient and sky must not be negative";
  TVL_CHECK_INPUT(bounce >= 0.0 && bounce <= 1.0)
      << "sim lighting: bounce = " << bounce << " is not in [0, 1]";
}

Lighting::Lighting(const LightingOptions& options)
    : sun_(static_cast<float>(options.sun)),
      ambient_(static_cast<float>(options.ambient)),
      bounce_(static_cast<float>(options.bounce)),
      sky_(static_cast<float>(options.sky)) {
  options.Check();
  const double c = std::cos(options.sun_elevation_rad);
  to_sun_ =
      Eigen::Vector3d(c * std::cos(options.sun_azimuth_rad), c * std::sin(options.sun_azimuth_rad),
                      std::sin(options.sun_elevation_rad))
          .cast<float>();
}

bool Lighting::FacesSun(const SceneHit& hit) const {
  return hit.material == Material::kFoliage || hit.normal.dot(to_sun_) > 0.0F;
}

float Lighting::Sky(const Eigen::Vector3f& direction, const TownTextures& textures) const {
  const float up = std::max(0.0F, direction.z());
  const float height = 1.0F / (up + 0.12F);  // flat clouds seen from below
  const float clouds = textures.Clouds(direction.x() * height, direction.y() * height, 0.02F);
  const float glow = std::max(0.0F, direction.dot(to_sun_));
  return sky_ * (1.0F - 0.55F * up + 0.15F * (clouds - 0.5F) + 0.5F * glow * glow * glow);
}

float Lighting::Surface(const SceneHit& hit, const Eigen::Vector3f& direction, float albedo,
                        bool sunlit) const {
  if (hit.material == Material::kTunnelFixture) return 1.5F;  // a lamp
  const float up = 0.5F + 0.5F * hit.normal.z();
  float irradiance = ambient_ * (bounce_ + (1.0F - bounce_) * up);
  if (sunlit) {
    const float cosine = hit.normal.dot(to_sun_);
    const bool through = hit.material == Material::kFoliage && cosine < 0.0F;
    irradiance += sun_ * (through ? -kLeafTransmission * cosine : std::max(0.0F, cosine));
  }
  const float gloss = Gloss(hit.material);
  if (gloss == 0.0F) return albedo * irradiance;
  const float mirror_up = direction.z() - 2.0F * direction.dot(hit.normal) * hit.normal.z();
  const float mirrored = sky_ * std::clamp(0.25F + 2.0F * mirror_up, 0.1F, 0.9F);
  return albedo * irradiance + gloss * mirrored;
}

}  // namespace tvl::sim
