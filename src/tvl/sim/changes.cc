#include "tvl/sim/changes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr uint64_t kChangesStream = 1000000;  // and the place's number
constexpr double kLookEvery_s = 0.3;          // 3 m of way
constexpr double kAlwaysSeen_m = 15.0;        // whatever the rays say
constexpr double kDrawn_m = 250.0;
// Numbers of traffic lie below.
constexpr uint32_t kFirstStay = 0x1000000U;
// Parked cars keep this free around them, half of what two neighbours do together.
constexpr double kSpareLength_m = 0.3, kSpareWidth_m = 0.1;

constexpr double kForever_s = std::numeric_limits<double>::infinity();

bool IsOf(const PrototypeRange& range, uint32_t prototype) {
  return prototype >= range.first && prototype < range.first + range.count;
}

bool IsParkedCar(const Prototypes& p, uint32_t prototype) {
  return IsOf(p.car, prototype) || IsOf(p.van, prototype);
}

bool IsMovable(const Prototypes& p, uint32_t prototype) {
  return IsParkedCar(p, prototype) || IsOf(p.bin, prototype);
}

bool IsPlant(const Prototypes& p, uint32_t prototype) {
  return IsOf(p.broadleaf, prototype) || IsOf(p.conifer, prototype) ||
         IsOf(p.big_tree, prototype) || IsOf(p.bush, prototype);
}

// Where a mesh is looked for: corners and middle of its box, low, at half its height and on top.
std::vector<Vector3f> LookoutPoints(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Vector3f& v : mesh.vertices) box.extend(v);
  const Vector3f middle = box.center(), half = 0.5F * box.sizes();
  std::vector<Vector3f> points;
  for (const float z : {0.3F, 0.6F, 1.0F}) {
    const float height = z * box.max().z();
    points.emplace_back(middle.x(), middle.y(), height);
    for (const float x : {-1.0F, 1.0F}) {
      for (const float y : {-1.0F, 1.0F}) {
        points.emplace_back(middle.x() + x * half.x(), middle.y() + y * half.y(), height);
      }
    }
  }
  return points;
}

// Tells when a thing can be seen, houses and ground alone being in the way.
class Lookout {
 public:
  Lookout(const SceneDescription& houses, const Prototypes& prototypes, const SensorPath& path)
      : scene_(houses), view_(scene_.View(0.0, 0.0)) {
    for (const Mesh& mesh : prototypes.meshes) points_.push_back(LookoutPoints(mesh));
    for (double t = 0.0; t <= path.end_s; t += kLookEvery_s) {
      eyes_.push_back(path.T_world_lidar.At(t).t());
    }
  }

  // Times between two passes at which nobody can see the thing.
  std::vector<double> Gaps(const SceneInstance& thing, const ChangeOptions& options) const {
    std::vector<Vector3d> points;
    for (const Vector3f& p : points_[thing.prototype]) {
      points.push_back(thing.T_world_object * p.cast<double>());
    }
    std::vector<double> gaps;
    double passed_s = -1.0, seen_s = -1.0;  // last; not yet
    Hidden longest;
    for (size_t i = 0; i < eyes_.size(); ++i) {
      if (!Sees(eyes_[i], points, options.sight_m)) continue;
      const double now_s = kLookEvery_s * static_cast<double>(i);
      if (seen_s >= 0.0 && now_s - seen_s > longest.Length_s()) longest = {seen_s, now_s};
      seen_s = now_s;
      if ((points.front() - eyes_[i]).head<2>().norm() > options.pass_m) continue;
      if (passed_s >= 0.0 && now_s - passed_s >= options.pass_gap_s &&
          longest.Length_s() >= options.hidden_s) {
        gaps.push_back(0.5 * (longest.begin_s + longest.end_s));
      }
      passed_s = now_s, longest = {};
    }
    return gaps;
  }

 private:
  struct Hidden {
    double begin_s = 0.0, end_s = 0.0;
    double Length_s() const { return end_s - begin_s; }
  };
  bool Sees(const Vector3d& eye, const std::vector<Vector3d>& points, double sight_m) const {
    const double away_m = (points.front() - eye).head<2>().norm();
    if (away_m > sight_m) return false;
    if (away_m < kAlwaysSeen_m) return true;
    for (size_t i = 0; i < points.size();) {
      RayPacket rays;
      for (; i < points.size() && rays.count < RayPacket::kWidth; ++i) {
        const Vector3d ray = points[i] - eye;
        rays.Set(rays.count, eye.cast<float>(), ray.normalized().cast<float>(),
                 static_cast<float>(ray.norm()));
      }
      if (view_.Occluded(rays) != (1U << rays.count) - 1U) return true;
    }
    return false;
  }

  Scene scene_;
  SceneView view_;
  std::vector<std::vector<Vector3f>> points_;  // of each prototype
  std::vector<Vector3d> eyes_;
};

Rigid3d Moved(const SceneInstance& thing, double x_m, double y_m, double yaw_rad) {
  return thing.T_world_object *
         Rigid3d(Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ())),
                 Vector3d(x_m, y_m, 0.0));
}

// A car in the place of another: one that fits, not quite where the other was.
SceneInstance AnotherCar(const SceneInstance& first, const Prototypes& p, Rng* rng) {
  const CarShape& room = p.ShapeOf(first.prototype);
  uint32_t prototype = first.prototype;
  for (int tries = 0; tries < 4; ++tries) {
    const uint32_t other = p.car.Pick(rng);
    const CarShape& shape = p.ShapeOf(other);
    if (shape.length_m <= room.length_m + 2.0 * kSpareLength_m &&
        shape.width_m <= room.width_m + kSpareWidth_m) {
      prototype = other;
    }
  }
  const CarShape& shape = p.ShapeOf(prototype);
  const double along = 0.5 * (room.length_m - shape.length_m) + kSpareLength_m;
  const double across = std::min(0.15, 0.5 * (room.width_m - shape.width_m) + 0.5 * kSpareWidth_m);
  const double turned = rng->Uniform() < 0.2 ? kPi : 0.0;
  return {prototype, Moved(first, rng->Uniform(-along, along), rng->Uniform(-across, across),
                           turned + rng->Uniform(-0.01, 0.01))};
}

SceneInstance Another(const SceneInstance& first, const Prototypes& p, Rng* rng) {
  if (IsParkedCar(p, first.prototype)) return AnotherCar(first, p, rng);
  if (IsPlant(p, first.prototype)) {
    return {first.prototype, Moved(first, 0.0, 0.0, rng->Uniform(0.0, 2.0 * kPi))};
  }
  return {first.prototype, Moved(first, 0.0, rng->Uniform(-0.3, 0.3), rng->Uniform(-0.3, 0.3))};
}

// Who stands in a place over time. `changes_s`: when it may change.
std::vector<Stay> StaysOf(const SceneInstance& first, const Prototypes& prototypes,
                          const std::vector<double>& changes_s, double share, Rng* rng) {
  const bool can_go = !changes_s.empty() && IsMovable(prototypes, first.prototype);
  // A third of the changing places is empty at any time: half of those taken are left, all empty
  // ones are taken.
  bool is_taken = !(can_go && rng->Uniform() < share / 3.0);
  std::vector<Stay> stays;
  SceneInstance thing = first;
  double since_s = -kForever_s;
  for (const double change_s : changes_s) {
    const double draw = rng->Uniform(), leaving = rng->Uniform();
    const SceneInstance next = Another(first, prototypes, rng);
    if (draw >= share) continue;
    if (is_taken) stays.push_back({since_s, change_s, thing});
    is_taken = !can_go || !is_taken || leaving < 0.5;
    thing = next, since_s = change_s;
  }
  if (is_taken) stays.push_back({since_s, kForever_s, thing});
  return stays;
}

}  // namespace

ChangingThings::ChangingThings(std::vector<Stay> stays, PoseSpline T_world_lidar,
                               std::shared_ptr<const MoverSource> others)
    : stays_(std::move(stays)),
      T_world_lidar_(std::move(T_world_lidar)),
      others_(std::move(others)) {}

std::vector<SceneMover> ChangingThings::Movers(double begin_s, double end_s) const {
  std::vector<SceneMover> movers;
  if (others_ != nullptr) movers = others_->Movers(begin_s, end_s);
  const double now_s = 0.5 * (begin_s + end_s);
  const Vector3d eye = T_world_lidar_.At(now_s).t();
  for (size_t i = 0; i < stays_.size(); ++i) {
    const Stay& stay = stays_[i];
    if (now_s < stay.begin_s || now_s >= stay.end_s) continue;
    const Rigid3d& T = stay.thing.T_world_object;
    if ((T.t() - eye).head<2>().norm() > kDrawn_m) continue;
    movers.push_back({stay.thing.prototype, kFirstStay + static_cast<uint32_t>(i), T, T});
  }
  return movers;
}

SceneDescription WithChanges(SceneDescription description, const Prototypes& prototypes,
                             const SensorPath& path, const ChangeOptions& options) {
  if (options.share == 0.0) return description;
  SceneDescription houses;
  houses.structures = std::move(description.structures);
  const Lookout lookout(houses, prototypes, path);
  std::vector<SceneInstance> still;
  std::vector<Stay> stays;
  for (size_t i = 0; i < description.instances.size(); ++i) {
    const SceneInstance& thing = description.instances[i];
    std::vector<double> gaps_s;
    if (IsMovable(prototypes, thing.prototype) || IsPlant(prototypes, thing.prototype)) {
      gaps_s = lookout.Gaps(thing, options);
    }
    Rng rng(options.seed, kChangesStream + i);
    const std::vector<Stay> here = StaysOf(thing, prototypes, gaps_s, options.share, &rng);
    if (here.size() == 1 && here[0].begin_s == -kForever_s && here[0].end_s == kForever_s) {
      still.push_back(thing);
    } else {
      stays.insert(stays.end(), here.begin(), here.end());
    }
  }
  description.structures = std::move(houses.structures);
  description.instances = std::move(still);
  description.movers = std::make_shared<ChangingThings>(std::move(stays), path.T_world_lidar,
                                                        std::move(description.movers));
  return description;
}

}  // namespace tvl::sim
