// Triangle meshes of the simulated town.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "tvl/sim/material.h"

namespace tvl::sim {

// Vertices in the object's own frame (x forward or along the facade, y left, z up), m. Triangles
// are two-sided: their winding has no meaning.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Material> materials;  // one a triangle
};

}  // namespace tvl::sim
