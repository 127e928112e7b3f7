#include "tvl/sim/material.h"

namespace tvl::sim {
namespace {

struct Entry {
  const char* name;
  LidarSurface surface;
};

// Reflectivities at 905 nm: vegetation is bright there, asphalt, tyres and roofs are dark.
constexpr Entry kEntries[kMaterialCount] = {
    {"asphalt", {0.30F, 0.20F, 0.0F}},
    {"pavement", {0.36F, 0.20F, 0.0F}},
    {"kerb", {0.38F, 0.20F, 0.0F}},
    {"road_marking", {0.75F, 0.20F, 0.0F}},
    {"grass", {0.45F, 0.30F, 0.0F}},
    {"soil", {0.30F, 0.30F, 0.0F}},
    {"plaster", {0.46F, 0.15F, 0.0F}},
    {"brick", {0.35F, 0.25F, 0.0F}},
    {"concrete", {0.36F, 0.20F, 0.0F}},
    {"window_glass", {0.12F, 0.90F, 0.40F}},
    {"window_frame", {0.50F, 0.15F, 0.0F}},
    {"door", {0.30F, 0.30F, 0.0F}},
    {"roof", {0.25F, 0.25F, 0.0F}},
    {"wood", {0.35F, 0.30F, 0.0F}},
    {"metal", {0.40F, 0.30F, 0.05F}},
    {"sign", {0.95F, 0.05F, 0.0F}},
    {"bark", {0.30F, 0.30F, 0.0F}},
    {"foliage", {0.45F, 0.40F, 0.0F}},
    {"car_paint", {0.30F, 0.90F, 0.05F}},
    {"car_glass", {0.05F, 0.90F, 0.70F}},
    {"car_trim", {0.20F, 0.60F, 0.05F}},
    {"tyre", {0.06F, 0.30F, 0.1F}},
    {"clothing", {0.35F, 0.50F, 0.0F}},
    {"skin", {0.50F, 0.10F, 0.0F}},
    {"tunnel_wall", {0.30F, 0.15F, 0.0F}},
    {"tunnel_fixture", {0.40F, 0.30F, 0.0F}},
    {"tarpaulin", {0.45F, 0.40F, 0.0F}},
    {"rich_asphalt", {0.30F, 0.20F, 0.0F}},
    {"smooth_asphalt", {0.30F, 0.05F, 0.0F}},
    // Water swallows half of the light of 905 nm that enters; of what is mirrored nothing returns.
    {"wet_asphalt", {0.15F, 0.10F, 0.0F, 1.4F}},
};

}  // namespace

LidarSurface LidarSurfaceOf(Material material) {
  return kEntries[static_cast<size_t>(material)].surface;
}

const char* ToString(Material material) { return kEntries[static_cast<size_t>(material)].name; }

}  // namespace tvl::sim
