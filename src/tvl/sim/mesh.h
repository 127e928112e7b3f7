// Triangle meshes of the simulated town, and the shapes they are put together from.
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

  void AddTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                   Material material);
  // Corners in order around the quad.
  void AddQuad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
               const Eigen::Vector3f& d, Material material);
  // A convex polygon, corners in order.
  void AddPolygon(const std::vector<Eigen::Vector3f>& corners, Material material);
  // Axis-parallel box between two opposite corners, all six sides.
  void AddBox(const Eigen::Vector3f& low, const Eigen::Vector3f& high, Material material);
  // Side of a (truncated) cone from `base` to `top` with the given radii; `sides` >= 3.
  void AddCone(const Eigen::Vector3f& base, const Eigen::Vector3f& top, float base_radius_m,
               float top_radius_m, int sides, Material material);
  // A closed cylinder.
  void AddCylinder(const Eigen::Vector3f& base, const Eigen::Vector3f& top, float radius_m,
                   int sides, Material material);
  // An ellipsoid of `rings` x 2 rings facets.
  void AddEllipsoid(const Eigen::Vector3f& centre, const Eigen::Vector3f& radii_m, int rings,
                    Material material);
  // A rectangle centred at `centre`, spanned by the half axes u and v.
  void AddCard(const Eigen::Vector3f& centre, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
               Material material);
};

}  // namespace tvl::sim
