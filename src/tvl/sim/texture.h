// What the surfaces of the simulated town look like: albedo as a pure function of material, place
// on the object, object and seed. Textures are stuck to their objects; detail below the footprint
// of the pixel fades out, so that nothing flickers between frames.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/sim/material.h"
#include "tvl/sim/texture_tile.h"

namespace tvl::sim {

// A place to look up. Coordinates of the object's own frame (SceneHit::p_object), m.
struct SurfacePoint {
  Material material = Material::kAsphalt;
  uint32_t object = 0;
  Eigen::Vector3f p_object = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal_object = Eigen::Vector3f::UnitZ();
  // The pixel's image on the surface: long axis as a vector in the object's frame (full length),
  // short axis as a length.
  Eigen::Vector3f major_m = Eigen::Vector3f::Zero();
  float minor_m = 0.01F;
};

struct TextureOptions {
  uint64_t seed = 1;
  // Houses look alike stain by stain: streets that a camera cannot tell apart.
  bool has_identical_houses = false;
};

// Immutable, thread-safe. Construction paints about 12 MB of patterns (0.2 s).
class TownTextures {
 public:
  explicit TownTextures(const TextureOptions& options);

  // Share of the light that is sent back, 0..1.
  float Albedo(const SurfacePoint& at) const;

  // Slowly varying field over a plane, about 0..1 around 0.5: clouds and the like.
  float Clouds(float u, float v, float footprint) const { return noise_.Sample(u, v, footprint); }

 private:
  float AlbedoOf(const SurfacePoint& at) const;
  float GroundAlbedo(const SurfacePoint& at) const;
  float Asphalt(const SurfacePoint& at, bool has_lids) const;
  float RichAsphalt(const SurfacePoint& at) const;
  float PlainAsphalt(const SurfacePoint& at, float base, float contrast) const;
  float RoadMarking(const SurfacePoint& at) const;
  float Ground(const SurfacePoint& at, const TextureTile& tile, float base, float contrast) const;
  float Kerb(const SurfacePoint& at) const;
  float Facade(const SurfacePoint& at, const TextureTile& tile, float base, float contrast) const;
  float WindowGlass(const SurfacePoint& at) const;
  float Painted(const SurfacePoint& at) const;
  float Wood(const SurfacePoint& at) const;
  float Sign(const SurfacePoint& at) const;
  float Bark(const SurfacePoint& at) const;
  float Foliage(const SurfacePoint& at) const;
  float CarPaint(const SurfacePoint& at) const;
  float CarGlass(const SurfacePoint& at) const;
  float CarTrim(const SurfacePoint& at) const;
  float Clothing(const SurfacePoint& at) const;
  float Tarpaulin(const SurfacePoint& at) const;
  float TunnelWall(const SurfacePoint& at) const;

  // A fixed random number in 0..1 of an object.
  float OfObject(uint32_t object, uint32_t what) const;
  // A fixed random number in 0..1 of a cell of a grid.
  float OfCell(int x, int y, uint32_t what) const;

  uint64_t seed_;
  bool has_identical_houses_;
  TextureTile noise_, asphalt_, bricks_, plaster_, leaves_, grass_, slabs_, roof_tiles_, lining_;
};

}  // namespace tvl::sim
