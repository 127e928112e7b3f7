#include "tvl/sim/material.h"

namespace tvl::sim {
namespace {

struct Entry {
  const char* name;
  LidarSurface surface;
};

// Reflectivities at 905 nm: vegetation is bright there, asphalt, tyres and roofs are dark.
constexpr Entry kEntries[kMaterialCount] = {
    {"asphalt", {0.22F, 0.25F, 0.0F}},      {"pavement", {0.32F, 0.20F, 0.0F}},
    {"kerb", {0.36F, 0.20F, 0.0F}},         {"road_marking", {0.75F, 0.20F, 0.0F}},
    {"grass", {0.42F, 0.30F, 0.0F}},        {"soil", {0.28F, 0.30F, 0.0F}},
    {"plaster", {0.45F, 0.15F, 0.0F}},      {"brick", {0.33F, 0.25F, 0.0F}},
    {"concrete", {0.34F, 0.20F, 0.0F}},     {"window_glass", {0.10F, 0.60F, 0.55F}},
    {"window_frame", {0.50F, 0.15F, 0.0F}}, {"door", {0.30F, 0.30F, 0.0F}},
    {"roof", {0.22F, 0.25F, 0.0F}},         {"wood", {0.35F, 0.30F, 0.0F}},
    {"metal", {0.40F, 0.30F, 0.1F}},        {"sign", {0.95F, 0.05F, 0.0F}},
    {"bark", {0.28F, 0.30F, 0.0F}},         {"foliage", {0.42F, 0.40F, 0.0F}},
    {"car_paint", {0.30F, 0.50F, 0.15F}},   {"car_glass", {0.08F, 0.50F, 0.85F}},
    {"car_trim", {0.20F, 0.60F, 0.1F}},     {"tyre", {0.06F, 0.30F, 0.2F}},
    {"clothing", {0.35F, 0.50F, 0.0F}},     {"skin", {0.50F, 0.10F, 0.0F}},
    {"tunnel_wall", {0.30F, 0.15F, 0.0F}},  {"tunnel_fixture", {0.40F, 0.30F, 0.0F}},
};

}  // namespace

LidarSurface LidarSurfaceOf(Material material) {
  return kEntries[static_cast<size_t>(material)].surface;
}

const char* ToString(Material material) { return kEntries[static_cast<size_t>(material)].name; }

}  // namespace tvl::sim
