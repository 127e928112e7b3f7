// Sun, sky and what a surface sends to the camera. Radiance 1 is the white of a camera at gain 1.
#pragma once

#include <Eigen/Core>

#include "tvl/sim/scene.h"
#include "tvl/sim/texture.h"

namespace tvl::sim {

struct LightingOptions {
  double sun_elevation_rad = 0.75;  // 43 deg: shadows as long as things are high, as on KITTI
  double sun_azimuth_rad = 2.1;     // in the world frame, from x towards y
  double sun = 2.0;                 // irradiance of a surface facing the sun
  double ambient = 0.48;            // irradiance of a surface facing up, from the sky alone
  double bounce = 0.45;             // share of the ambient light that comes from below
  double sky = 2.0;                 // radiance at the horizon: over-exposed, as on real images
  // Throws InputError naming the field.
  void Check() const;
};

// Immutable, thread-safe.
class Lighting {
 public:
  explicit Lighting(const LightingOptions& options);

  const Eigen::Vector3f& to_sun() const { return to_sun_; }  // unit, world frame
  // Whether the sun could reach the hit if nothing stood in between.
  bool FacesSun(const SceneHit& hit) const;
  // Radiance of the sky in a direction (unit, world frame).
  float Sky(const Eigen::Vector3f& direction, const TownTextures& textures) const;
  // Radiance of a hit seen along `direction`.
  float Surface(const SceneHit& hit, const Eigen::Vector3f& direction, float albedo,
                bool sunlit) const;

 private:
  Eigen::Vector3f to_sun_;
  float sun_, ambient_, bounce_, sky_;
};

}  // namespace tvl::sim
