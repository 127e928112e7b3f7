// What a surface of the simulated town is made of.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tvl::sim {

// Decides the lidar's reflectivity (material.cc) and the camera's texture (texture.h).
enum class Material : uint8_t {
  kAsphalt,
  kPavement,     // slabs beside the road; yards
  kKerb,         // kerb stones: vertical face and top
  kRoadMarking,  // white paint on asphalt
  kGrass,
  kSoil,         // ploughed or bare ground, gravel
  kPlaster,      // facade
  kBrick,        // facade
  kConcrete,     // plinths, garden walls, balconies
  kWindowGlass,  // window panes of houses
  kWindowFrame,  // frames, sills, shutters
  kDoor,
  kRoof,   // tiles
  kWood,   // fences, benches
  kMetal,  // poles, posts, guard rails
  kSign,   // traffic signs, boards
  kBark,
  kFoliage,  // leaf cards of trees, hedges and bushes
  kCarPaint,
  kCarGlass,
  kCarTrim,  // bumpers, sills, plates, lamps
  kTyre,
  kClothing,  // pedestrians
  kSkin,
  kTunnelWall,
  kTunnelFixture,  // lamps and cables of a tunnel (texture only, no relief)
  kTarpaulin,      // sides of lorries: cloth with letters
  kRichAsphalt,    // of a highway: repairs and cracks
  kSmoothAsphalt,  // new, without marks
  kWetAsphalt,
  kCount
};

inline constexpr size_t kMaterialCount = static_cast<size_t>(Material::kCount);

// How a lidar pulse of 905 nm comes back from a surface.
struct LidarSurface {
  float reflectivity = 0.3F;  // diffuse, 0..1
  float variation = 0.2F;     // relative spread of the reflectivity over the surface
  float mirror = 0.0F;        // share of pulses lost to specular reflection or transmission, 0..1
  // A film of water: loses film * (1 - cosine of the incidence)^5 of the pulses, at most all: how
  // the share mirrored away by a smooth surface grows (Schlick 1994, equation 15).
  float film = 0.0F;
};

LidarSurface LidarSurfaceOf(Material material);

// Short name, e.g. "asphalt".
const char* ToString(Material material);

}  // namespace tvl::sim
