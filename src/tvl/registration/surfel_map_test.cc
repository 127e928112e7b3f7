#include "tvl/registration/surfel_map.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/mapping/local_map.h"

namespace tvl {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// Points of a room of 16 x 16 x 6 m about the sensor, with clutter.
Points RoomScan(uint64_t seed, int count = 6000) {
  Rng rng(seed);
  Points points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(rng.Uniform(-8, 8), rng.Uniform(-8, 8), rng.Uniform(-2, 4));
    if (i % 7 != 0) p[i % 3] = (i % 2 == 0 ? 1.0 : -1.0) * (i % 3 == 2 ? 2.0 : 8.0);
    for (int a = 0; a < 3; ++a) p[a] += 0.02 * rng.Normal();
    points.push_back(p.cast<float>());
  }
  return points;
}

Rigid3d SomePose(uint64_t seed) {
  Rng rng(seed);
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? 0.3 : 4.0) * rng.Normal();
  return Rigid3d::Exp(xi);
}

std::vector<Eigen::Vector3d> Queries(uint64_t seed, int count = 3000) {
  Rng rng(seed);
  std::vector<Eigen::Vector3d> queries;
  for (int i = 0; i < count; ++i) {
    queries.push_back({rng.Uniform(-14, 14), rng.Uniform(-14, 14), rng.Uniform(-6, 6)});
  }
  return queries;
}

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(double)) == 0; }

bool SameBits(const Surfel& a, const Surfel& b) {
  bool same = a.kind == b.kind && SameBits(a.count, b.count) &&
              SameBits(a.thickness_sq_m2, b.thickness_sq_m2) &&
              SameBits(a.extent_sq_m2, b.extent_sq_m2);
  for (int i = 0; i < 3; ++i) {
    same = same && SameBits(a.mean[i], b.mean[i]) && SameBits(a.axis[i], b.axis[i]);
  }
  return same;
}

// Queries both maps answer differently, to the bit.
int Differences(const SurfelMap& a, const SurfelMap& b) {
  int differences = 0;
  for (const Eigen::Vector3d& p : Queries(99)) {
    const Surfel *in_a = a.Find(p), *in_b = b.Find(p);
    const bool same =
        (in_a == nullptr) == (in_b == nullptr) && (in_a == nullptr || SameBits(*in_a, *in_b));
    if (!same) ++differences;
  }
  return differences;
}

int Answered(const SurfelMap& map) {
  int answered = 0;
  for (const Eigen::Vector3d& p : Queries(99)) answered += map.Find(p) != nullptr;
  return answered;
}

TEST(SurfelMap, RemoveLeavesNothingOfWhatWasAdded) {
  const Executor executor(1);
  SurfelMap map{SurfelMapOptions()}, never{SurfelMapOptions()};
  for (const uint64_t seed : {1, 2}) {
    map.Add(RoomScan(seed), SomePose(seed), executor);
    never.Add(RoomScan(seed), SomePose(seed), executor);
  }
  ASSERT_GT(Answered(never), 500);
  for (const uint64_t seed : {3, 4, 5}) map.Add(RoomScan(seed), SomePose(seed), executor);
  EXPECT_GT(Differences(map, never), 100);
  for (const uint64_t seed : {4, 5, 3}) map.Remove(RoomScan(seed), SomePose(seed), executor);
  EXPECT_EQ(Differences(map, never), 0);
  EXPECT_EQ(map.voxels(), never.voxels());
  for (const uint64_t seed : {1, 2}) map.Remove(RoomScan(seed), SomePose(seed), executor);
  EXPECT_EQ(map.voxels(), 0u);
  EXPECT_EQ(Answered(map), 0);
}

TEST(SurfelMap, IsTheSameForAnyOrderAndThreadCount) {
  SurfelMap one{SurfelMapOptions()}, two{SurfelMapOptions()};
  const Executor single(1), pair(2);
  for (const uint64_t seed : {1, 2, 3}) one.Add(RoomScan(seed), SomePose(seed), single);
  for (const uint64_t seed : {3, 1, 2}) two.Add(RoomScan(seed), SomePose(seed), pair);
  EXPECT_EQ(Differences(one, two), 0);
  EXPECT_EQ(one.voxels(), two.voxels());
}

// Find by definition: every voxel of a level fitted anew from its points; of the surfels of the
// eight voxels whose common corner is nearest, the one whose mean is nearest and within a voxel.
class BruteForceMap {
 public:
  BruteForceMap(const Points& points, const Rigid3d& T, SurfelMapOptions options)
      : options_(std::move(options)) {
    for (const double size_m : options_.sizes_m) {
      std::map<Index, PointMoments> cells;
      for (const auto& point : points) {
        const Eigen::Vector3d p = T.R() * point.cast<double>() + T.t();
        const VoxelKey key = VoxelKey::Of(p, size_m);
        cells[{key.x, key.y, key.z}].Add(p - key.Centre(size_m), 1);
      }
      levels_.push_back(std::move(cells));
    }
  }

  Surfel Find(const Eigen::Vector3d& p) const {
    for (size_t level = 0; level < levels_.size(); ++level) {
      const Surfel found = FindAt(level, p);
      if (found.kind != SurfelKind::kNone) return found;
    }
    return {};
  }

 private:
  using Index = std::tuple<int, int, int>;

  Surfel FindAt(size_t level, const Eigen::Vector3d& p) const {
    const double size_m = options_.sizes_m[level];
    Surfel best;
    double best_m = size_m;
    for (const auto& [index, moments] : levels_[level]) {
      const auto [x, y, z] = index;
      const Eigen::Vector3d centre = VoxelKey{x, y, z}.Centre(size_m);
      if ((centre - p).cwiseAbs().maxCoeff() > size_m) continue;  // not one of the eight
      const Surfel surfel = FitPlane(moments, centre, size_m, options_.surfel);
      if (surfel.kind == SurfelKind::kNone || (surfel.mean - p).norm() >= best_m) continue;
      best = surfel;
      best_m = (surfel.mean - p).norm();
    }
    return best;
  }

  SurfelMapOptions options_;
  std::vector<std::map<Index, PointMoments>> levels_;
};

TEST(SurfelMap, FindAgreesWithBruteForce) {
  const Points points = RoomScan(8, 6000);
  const Rigid3d T = SomePose(8);
  SurfelMapOptions options;
  options.sizes_m = {0.8, 2.0};
  SurfelMap map(options);
  map.Add(points, T, Executor(1));
  const BruteForceMap reference(points, T, options);
  int found = 0, none = 0;
  for (const Eigen::Vector3d& p : Queries(12, 1500)) {
    const Surfel expected = reference.Find(p);
    const Surfel* actual = map.Find(p);
    ASSERT_EQ(actual != nullptr, expected.kind != SurfelKind::kNone);
    if (actual == nullptr) {
      ++none;
      continue;
    }
    ++found;
    EXPECT_TRUE(SameBits(*actual, expected));
  }
  EXPECT_GT(found, 50);
  EXPECT_GT(none, 50);
}

TEST(SurfelMap, TheFinestLevelThatKnowsAnswers) {
  Rng rng(13);
  Points dense, sparse;
  for (int i = 0; i < 400; ++i) {
    dense.push_back(
        {static_cast<float>(rng.Uniform(0, 2)), static_cast<float>(rng.Uniform(0, 2)), 0.1f});
  }
  for (int i = 0; i < 60; ++i) {
    sparse.push_back(
        {static_cast<float>(rng.Uniform(20, 24)), static_cast<float>(rng.Uniform(0, 4)), 0.1f});
  }
  SurfelMap map{SurfelMapOptions()};
  map.Add(dense, Rigid3d(), Executor(1));
  map.Add(sparse, Rigid3d(), Executor(1));
  const Surfel *fine = map.Find({1.0, 1.0, 0.1}), *coarse = map.Find({22.0, 2.0, 0.1});
  ASSERT_TRUE(fine != nullptr && coarse != nullptr);
  EXPECT_LT(fine->extent_sq_m2, 0.5 * 0.5 / 12.0 * 1.5);  // a 0.5 m voxel's
  EXPECT_GT(coarse->extent_sq_m2, 1.0 / 12.0);            // not a 1 m voxel's
  EXPECT_EQ(map.Find({10.0, 10.0, 0.1}), nullptr);
}

TEST(SurfelMapOptions, NamesTheBadField) {
  SurfelMapOptions options;
  options.sizes_m = {};
  EXPECT_THROW(SurfelMap{options}, InputError);
}

Keyframe MakeKeyframe(uint64_t seed, double path_m) {
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = RoomScan(seed, 2000);
  cloud->edges.points = RoomScan(seed + 1000, 300);
  Keyframe keyframe;
  keyframe.T_world_lidar = SomePose(seed);
  keyframe.path_m = path_m;
  keyframe.cloud = cloud;
  return keyframe;
}

TEST(LocalMap, IsTheCacheOfTheKeyframesRecentByPath) {
  LocalMapOptions options;
  options.keep_path_m = 5.0;
  LocalMap incremental(options), rebuilt(options);
  const Executor executor(2);
  for (uint64_t k = 0; k < 14; ++k) {
    incremental.Add(MakeKeyframe(k, static_cast<double>(k)), executor);
  }
  for (uint64_t k = 8; k < 14; ++k) {
    rebuilt.Add(MakeKeyframe(k, static_cast<double>(k)), executor);
  }
  EXPECT_EQ(incremental.size(), 6u);
  EXPECT_EQ(incremental.planes().voxels(), rebuilt.planes().voxels());
  EXPECT_EQ(incremental.lines().voxels(), rebuilt.lines().voxels());
  EXPECT_GT(Answered(incremental.planes()), 100);
  EXPECT_EQ(Differences(incremental.planes(), rebuilt.planes()), 0);
  EXPECT_EQ(Differences(incremental.lines(), rebuilt.lines()), 0);
}

}  // namespace
}  // namespace tvl
