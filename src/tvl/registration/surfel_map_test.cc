#include "tvl/registration/surfel_map.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/registration/test_surfels.h"

namespace tvl {
namespace {

using synthetic::Answered;
using synthetic::Differences;
using synthetic::Points;
using synthetic::Queries;
using synthetic::RoomScan;
using synthetic::SameBits;
using synthetic::SomePose;

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

}  // namespace
}  // namespace tvl
