#include "tvl/sim/mesh.h"

#include <Eigen/Geometry>
#include <cmath>

#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

// Two unit vectors that form a right-handed frame with `axis` (unit).
std::array<Vector3f, 2> Perpendicular(const Vector3f& axis) {
  const Vector3f u = axis.unitOrthogonal();
  return {u, axis.cross(u)};
}

Vector3f OnCircle(const std::array<Vector3f, 2>& frame, int step, int steps) {
  const float angle =
      static_cast<float>(2.0 * kPi) * static_cast<float>(step % steps) / static_cast<float>(steps);
  return std::cos(angle) * frame[0] + std::sin(angle) * frame[1];
}

}  // namespace

void Mesh::AddTriangle(const Vector3f& a, const Vector3f& b, const Vector3f& c, Material material) {
  AddPolygon({a, b, c}, material);
}

void Mesh::AddQuad(const Vector3f& a, const Vector3f& b, const Vector3f& c, const Vector3f& d,
                   Material material) {
  AddPolygon({a, b, c, d}, material);
}

void Mesh::AddPolygon(const std::vector<Vector3f>& corners, Material material) {
  const auto first = static_cast<uint32_t>(vertices.size());
  vertices.insert(vertices.end(), corners.begin(), corners.end());
  for (uint32_t i = 2; i < corners.size(); ++i) {
    triangles.push_back({first, first + i - 1, first + i});
    materials.push_back(material);
  }
}

void Mesh::AddBox(const Vector3f& low, const Vector3f& high, Material material) {
  const auto corner = [&](int i) {
    return Vector3f((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                    (i & 4) != 0 ? high.z() : low.z());
  };
  constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    AddQuad(corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]), material);
  }
}

void Mesh::AddCone(const Vector3f& base, const Vector3f& top, float base_radius_m,
                   float top_radius_m, int sides, Material material) {
  const auto frame = Perpendicular((top - base).normalized());
  for (int i = 0; i < sides; ++i) {
    const Vector3f a = OnCircle(frame, i, sides), b = OnCircle(frame, i + 1, sides);
    AddQuad(base + base_radius_m * a, base + base_radius_m * b, top + top_radius_m * b,
            top + top_radius_m * a, material);
  }
}

void Mesh::AddCylinder(const Vector3f& base, const Vector3f& top, float radius_m, int sides,
                       Material material) {
  AddCone(base, top, radius_m, radius_m, sides, material);
  const auto frame = Perpendicular((top - base).normalized());
  std::vector<Vector3f> low, high;
  for (int i = 0; i < sides; ++i) {
    low.push_back(base + radius_m * OnCircle(frame, i, sides));
    high.push_back(top + radius_m * OnCircle(frame, i, sides));
  }
  AddPolygon(low, material);
  AddPolygon(high, material);
}

void Mesh::AddEllipsoid(const Vector3f& centre, const Vector3f& radii_m, int rings,
                        Material material) {
  const auto point = [&](int ring, int step) {
    const float polar =
        static_cast<float>(kPi) * static_cast<float>(ring) / static_cast<float>(rings);
    const float angle = static_cast<float>(kPi) * static_cast<float>(step % (2 * rings)) /
                        static_cast<float>(rings);
    const Vector3f unit(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                        std::cos(polar));
    return Vector3f(centre + radii_m.cwiseProduct(unit));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int step = 0; step < 2 * rings; ++step) {
      AddQuad(point(ring, step), point(ring, step + 1), point(ring + 1, step + 1),
              point(ring + 1, step), material);
    }
  }
}

void Mesh::AddCard(const Vector3f& centre, const Vector3f& u, const Vector3f& v,
                   Material material) {
  AddQuad(centre - u - v, centre + u - v, centre + u + v, centre - u + v, material);
}

}  // namespace tvl::sim
