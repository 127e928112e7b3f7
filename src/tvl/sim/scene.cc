#include "tvl/sim/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/sim/embree_api.h"

namespace tvl::sim {
namespace {

constexpr int kWidth = RayPacket::kWidth;
// Object numbers of movers start here; those of still things are their place in the scene.
constexpr uint32_t kFirstMoverObject = 0x40000000U;

using RowMajor34f = Eigen::Matrix<float, 3, 4, Eigen::RowMajor>;

RowMajor34f ToFloat(const Rigid3d& T) { return T.Matrix().cast<float>(); }

void SetTransform(RTCGeometry geometry, unsigned step, const RowMajor34f& T) {
  rtcSetGeometryTransform(geometry, step, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, T.data());
}

// Copies a mesh, transformed, into an Embree geometry attached to `scene`. Returns its number.
unsigned AttachMesh(RTCDevice device, RTCScene scene, const Mesh& mesh, const RowMajor34f& T) {
  TVL_CHECK(mesh.materials.size() == mesh.triangles.size()) << "one material a triangle";
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), std::max<size_t>(1, mesh.vertices.size())));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), std::max<size_t>(1, mesh.triangles.size())));
  TVL_CHECK(vertices != nullptr && indices != nullptr) << "out of memory for the scene";
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f p = T.leftCols<3>() * mesh.vertices[i] + T.col(3);
    std::copy_n(p.data(), 3, vertices + 3 * i);
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::copy_n(mesh.triangles[i].data(), 3, indices + 3 * i);
  }
  if (mesh.triangles.empty()) std::fill_n(indices, 3, 0U);
  rtcCommitGeometry(geometry);
  const unsigned number = rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return number;
}

unsigned AttachInstance(RTCDevice device, RTCScene scene, RTCScene prototype,
                        const RowMajor34f& T_begin, const RowMajor34f* T_end) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, prototype);
  if (T_end != nullptr) rtcSetGeometryTimeStepCount(geometry, 2);
  SetTransform(geometry, 0, T_begin);
  if (T_end != nullptr) SetTransform(geometry, 1, *T_end);
  rtcCommitGeometry(geometry);
  const unsigned number = rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return number;
}

void LoadRays(const RayPacket& rays, RTCRay8* ray) {
  std::memcpy(ray->org_x, rays.origin_x.data(), sizeof(ray->org_x));
  std::memcpy(ray->org_y, rays.origin_y.data(), sizeof(ray->org_y));
  std::memcpy(ray->org_z, rays.origin_z.data(), sizeof(ray->org_z));
  std::memcpy(ray->dir_x, rays.direction_x.data(), sizeof(ray->dir_x));
  std::memcpy(ray->dir_y, rays.direction_y.data(), sizeof(ray->dir_y));
  std::memcpy(ray->dir_z, rays.direction_z.data(), sizeof(ray->dir_z));
  std::memcpy(ray->time, rays.share.data(), sizeof(ray->time));
  std::memcpy(ray->tfar, rays.max_range_m.data(), sizeof(ray->tfar));
  for (int i = 0; i < kWidth; ++i) {
    ray->tnear[i] = 0.0F, ray->mask[i] = 0xffffffffU, ray->id[i] = 0, ray->flags[i] = 0;
  }
}

std::array<int, kWidth> ValidLanes(int count) {
  alignas(32) std::array<int, kWidth> valid{};
  for (int i = 0; i < count; ++i) valid[static_cast<size_t>(i)] = -1;
  return valid;
}

}  // namespace

struct Scene::Impl {
  embree::Device device;
  std::vector<embree::SceneHandle> prototypes;
  std::vector<std::vector<Material>> prototype_materials;
  embree::SceneHandle still;
  // By geometry number of the still scene.
  struct Object {
    RowMajor34f T_world_object;
    const std::vector<Material>* materials = nullptr;
  };
  std::vector<Object> objects;
  std::vector<std::vector<Material>> structure_materials;
  std::shared_ptr<const MoverSource> movers;
  size_t triangles = 0;

  void AddPrototypes(const std::vector<Mesh>& meshes) {
    for (const Mesh& mesh : meshes) {
      embree::SceneHandle scene(rtcNewScene(device.get()));
      AttachMesh(device.get(), scene.get(), mesh, ToFloat(Rigid3d()));
      rtcCommitScene(scene.get());
      prototypes.push_back(std::move(scene));
      prototype_materials.push_back(mesh.materials);
      triangles += mesh.triangles.size();
    }
  }

  void AddObject(unsigned number, const RowMajor34f& T, const std::vector<Material>* materials) {
    TVL_CHECK(number == objects.size()) << "geometries are numbered in order";
    objects.push_back({T, materials});
  }

  void AddStructures(const std::vector<SceneStructure>& structures) {
    structure_materials.reserve(structures.size());  // objects point into it
    for (const SceneStructure& s : structures) {
      structure_materials.push_back(s.mesh.materials);
      const RowMajor34f T = ToFloat(s.T_world_object);
      AddObject(AttachMesh(device.get(), still.get(), s.mesh, T), T, &structure_materials.back());
      triangles += s.mesh.triangles.size();
    }
  }

  void AddInstances(const std::vector<SceneInstance>& instances) {
    for (const SceneInstance& i : instances) {
      TVL_CHECK(i.prototype < prototypes.size()) << "prototype " << i.prototype;
      const RowMajor34f T = ToFloat(i.T_world_object);
      AddObject(
          AttachInstance(device.get(), still.get(), prototypes[i.prototype].get(), T, nullptr), T,
          &prototype_materials[i.prototype]);
    }
  }
};

Scene::Scene(const SceneDescription& description) : impl_(std::make_unique<Impl>()) {
  // One thread: the search trees, and with them the choice between surfaces hit at the same
  // distance, must not depend on scheduling.
  impl_->device.reset(rtcNewDevice("threads=1,set_affinity=0"));
  TVL_CHECK(impl_->device != nullptr) << "Embree did not start";
  impl_->movers = description.movers;
  impl_->still.reset(rtcNewScene(impl_->device.get()));
  impl_->AddPrototypes(description.prototypes);
  impl_->AddStructures(description.structures);
  impl_->AddInstances(description.instances);
  rtcCommitScene(impl_->still.get());
  const RTCError error = rtcGetDeviceError(impl_->device.get());
  TVL_CHECK(error == RTC_ERROR_NONE) << "Embree failed to build the scene, error " << int{error};
}

Scene::~Scene() = default;

size_t Scene::triangles() const { return impl_->triangles; }

struct SceneView::Impl {
  const Scene::Impl* scene;
  embree::SceneHandle moving;  // null: nothing moves
  struct Mover {
    RowMajor34f T_begin, T_end;
    uint32_t object;
    const std::vector<Material>* materials;
  };
  std::vector<Mover> movers;

  // Fills in what follows from the hit's object.
  static void Finish(const RowMajor34f& T_world_object, const Eigen::Vector3f& direction,
                     const Eigen::Vector3f& normal_object, SceneHit* hit) {
    const auto R = T_world_object.leftCols<3>();
    hit->normal_object = normal_object.normalized();
    hit->normal = (R * hit->normal_object).normalized();
    if (hit->normal.dot(direction) > 0.0F) {
      hit->normal = -hit->normal;
      hit->normal_object = -hit->normal_object;
    }
    hit->p_object = R.transpose() * (hit->p_world - T_world_object.col(3));
  }

  SceneHit FromMoving(const RTCRayHit8& r, int lane, float share, const Eigen::Vector3f& direction,
                      SceneHit hit) const {
    const Mover& mover = movers[r.hit.instID[0][lane]];
    hit.object = mover.object;
    hit.is_mover = true;
    hit.material = (*mover.materials)[r.hit.primID[lane]];
    const RowMajor34f T = (1.0F - share) * mover.T_begin + share * mover.T_end;
    Finish(T, direction, {r.hit.Ng_x[lane], r.hit.Ng_y[lane], r.hit.Ng_z[lane]}, &hit);
    return hit;
  }

  SceneHit FromStill(const RTCRayHit8& r, int lane, const Eigen::Vector3f& direction,
                     SceneHit hit) const {
    const bool is_instance = r.hit.instID[0][lane] != RTC_INVALID_GEOMETRY_ID;
    hit.object = is_instance ? r.hit.instID[0][lane] : r.hit.geomID[lane];
    const Scene::Impl::Object& object = scene->objects[hit.object];
    hit.material = (*object.materials)[r.hit.primID[lane]];
    Eigen::Vector3f normal(r.hit.Ng_x[lane], r.hit.Ng_y[lane], r.hit.Ng_z[lane]);
    // Structures were built in the world frame, instances in their own.
    if (!is_instance) normal = object.T_world_object.leftCols<3>().transpose() * normal;
    Finish(object.T_world_object, direction, normal, &hit);
    return hit;
  }
};

SceneView::SceneView(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SceneView::SceneView(SceneView&&) noexcept = default;
SceneView::~SceneView() = default;

SceneView Scene::View(double begin_s, double end_s) const {
  auto view = std::make_unique<SceneView::Impl>();
  view->scene = impl_.get();
  if (impl_->movers == nullptr) return SceneView(std::move(view));
  const std::vector<SceneMover> movers = impl_->movers->Movers(begin_s, end_s);
  if (movers.empty()) return SceneView(std::move(view));
  view->moving.reset(rtcNewScene(impl_->device.get()));
  for (const SceneMover& m : movers) {
    TVL_CHECK(m.prototype < impl_->prototypes.size()) << "prototype " << m.prototype;
    const RowMajor34f begin = ToFloat(m.T_world_object_begin), end = ToFloat(m.T_world_object_end);
    AttachInstance(impl_->device.get(), view->moving.get(), impl_->prototypes[m.prototype].get(),
                   begin, &end);
    view->movers.push_back(
        {begin, end, kFirstMoverObject + m.id, &impl_->prototype_materials[m.prototype]});
  }
  rtcCommitScene(view->moving.get());
  return SceneView(std::move(view));
}

HitPacket SceneView::Intersect(const RayPacket& rays) const {
  RTCRayHit8 r;
  LoadRays(rays, &r.ray);
  std::fill_n(r.hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
  std::fill_n(r.hit.instID[0], kWidth, RTC_INVALID_GEOMETRY_ID);
  alignas(32) const std::array<int, kWidth> valid = ValidLanes(rays.count);
  embree::Intersect8(valid.data(), impl_->scene->still.get(), &r);
  std::array<float, kWidth> still_range;
  std::copy_n(r.ray.tfar, kWidth, still_range.begin());
  if (impl_->moving != nullptr) embree::Intersect8(valid.data(), impl_->moving.get(), &r);

  HitPacket hits;
  for (int i = 0; i < rays.count; ++i) {
    const auto lane = static_cast<size_t>(i);
    if (r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const Eigen::Vector3f origin(r.ray.org_x[i], r.ray.org_y[i], r.ray.org_z[i]);
    const Eigen::Vector3f direction(r.ray.dir_x[i], r.ray.dir_y[i], r.ray.dir_z[i]);
    SceneHit hit;
    hit.hit = true;
    hit.range_m = r.ray.tfar[i];
    hit.p_world = origin + hit.range_m * direction;
    hits[lane] = hit.range_m < still_range[lane]
                     ? impl_->FromMoving(r, i, rays.share[lane], direction, hit)
                     : impl_->FromStill(r, i, direction, hit);
  }
  return hits;
}

uint32_t SceneView::Occluded(const RayPacket& rays) const {
  RTCRay8 r;
  LoadRays(rays, &r);
  alignas(32) const std::array<int, kWidth> valid = ValidLanes(rays.count);
  embree::Occluded8(valid.data(), impl_->scene->still.get(), &r);
  if (impl_->moving != nullptr) embree::Occluded8(valid.data(), impl_->moving.get(), &r);
  uint32_t mask = 0;
  // A blocked ray is marked by a negative tfar.
  for (int i = 0; i < rays.count; ++i) mask |= (r.tfar[i] < 0.0F ? 1U : 0U) << i;
  return mask;
}

}  // namespace tvl::sim
