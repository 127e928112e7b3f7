// Ray casting of the simulated world (Embree): the single source of geometry of lidar and camera.
//
// A Scene holds what stands still. A SceneView adds what moves during a short span of time: a
// sweep of the lidar or the instant of an image. All coordinates are those of the world frame of
// the simulation: x, y horizontal, z up, m.
//
//   const SceneView view = scene.View(t, t);             // an instant
//   RayPacket rays;                                       // 8 rays; neighbours should be alike
//   rays.Set(0, origin, direction, 200.0F);
//   const HitPacket hits = view.Intersect(rays);
//   if (hits[0].hit) ...
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/sim/mesh.h"

namespace tvl::sim {

// What a ray meets first.
struct SceneHit {
  bool hit = false;  // false: sky; the other fields are then meaningless
  Material material = Material::kAsphalt;
  // Identifies the thing hit (a house, a car, a tree, a piece of street); the same in every view.
  uint32_t object = 0;
  bool is_mover = false;  // told of by the MoverSource
  float range_m = 0.0F;
  Eigen::Vector3f p_world = Eigen::Vector3f::Zero();
  // The object's own frame: textures given in it are stuck to things that move. Houses: x along
  // the front facade, y towards the back, z up from the ground floor, origin at the middle of the
  // front; cars: x forward, y left, z up from the road, origin in the middle; streets: world.
  Eigen::Vector3f p_object = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();         // unit, world frame, on the ray's side
  Eigen::Vector3f normal_object = Eigen::Vector3f::Zero();  // the same in the object's frame
};

// Up to kWidth rays, cast together. Fastest when they are close to parallel.
struct RayPacket {
  static constexpr int kWidth = 8;
  int count = 0;  // lanes in use: [0, count)
  alignas(32) std::array<float, kWidth> origin_x, origin_y, origin_z;
  alignas(32) std::array<float, kWidth> direction_x, direction_y, direction_z;
  alignas(32) std::array<float, kWidth> max_range_m;
  alignas(32) std::array<float, kWidth> share;  // of the view's time span, 0..1

  // `direction` must have unit length. Lanes are to be set in order.
  void Set(int lane, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
           float max_range, float time_share = 0.0F) {
    const auto i = static_cast<size_t>(lane);
    origin_x[i] = origin.x(), origin_y[i] = origin.y(), origin_z[i] = origin.z();
    direction_x[i] = direction.x(), direction_y[i] = direction.y(), direction_z[i] = direction.z();
    max_range_m[i] = max_range;
    share[i] = time_share;
    count = lane + 1;
  }
};

using HitPacket = std::array<SceneHit, RayPacket::kWidth>;

// A thing placed in the world. `prototype` indexes SceneDescription::prototypes.
struct SceneInstance {
  uint32_t prototype = 0;
  Rigid3d T_world_object;
};

// A unique thing: a house, a piece of street.
struct SceneStructure {
  Mesh mesh;  // in the object's frame
  Rigid3d T_world_object;
};

// Something moving over a span of time, from one pose to the other.
struct SceneMover {
  uint32_t prototype = 0;
  uint32_t id = 0;  // stays the same through its life
  Rigid3d T_world_object_begin, T_world_object_end;
};

// Tells what moves. Const and thread-safe.
class MoverSource {
 public:
  virtual ~MoverSource() = default;
  // Everything present during [begin_s, end_s].
  virtual std::vector<SceneMover> Movers(double begin_s, double end_s) const = 0;
};

struct SceneDescription {
  std::vector<Mesh> prototypes;  // trees, cars, pedestrians: used many times
  std::vector<SceneStructure> structures;
  std::vector<SceneInstance> instances;
  std::shared_ptr<const MoverSource> movers;  // null: nothing moves
};

// The world during a short span of time. Keeps what it needs alive; must not outlive its Scene.
// Const and thread-safe.
class SceneView {
 public:
  SceneView(SceneView&&) noexcept;
  ~SceneView();

  // The first hit of each ray; lanes past rays.count are not hit.
  HitPacket Intersect(const RayPacket& rays) const;
  // Whether anything lies within each ray's max_range_m (shadow rays): bit i for lane i.
  uint32_t Occluded(const RayPacket& rays) const;

 private:
  friend class Scene;
  struct Impl;
  explicit SceneView(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Immutable and thread-safe after construction.
class Scene {
 public:
  // Builds the search trees. Throws tvl::Error when a prototype index is out of range or the
  // library runs out of memory.
  explicit Scene(const SceneDescription& description);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // The world during [begin_s, end_s]; movers go straight from their pose at its begin to that at
  // its end, RayPacket::share says when a ray is cast.
  SceneView View(double begin_s, double end_s) const;

  size_t triangles() const;  // of structures and prototypes, each counted once

 private:
  friend class SceneView;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl::sim
