#include "tvl/loop/loop_submap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

// Keyframes 1 m apart along x; each sees points of a wall and a floor, in its own frame.
struct Street {
  std::vector<Rigid3d> T_odom_lidar;
  std::vector<std::shared_ptr<const KeyframeCloud>> clouds;
  mutable int fetched = 0;

  explicit Street(int n) {
    for (int k = 0; k < n; ++k) {
      T_odom_lidar.push_back(Rigid3d::Translation(k, 0.02 * k, 0.01 * k));
      Rng rng(static_cast<uint64_t>(k));
      auto cloud = std::make_shared<KeyframeCloud>();
      for (int i = 0; i < 600; ++i) {
        const double x = rng.Uniform(-8, 8);
        const Eigen::Vector3d p = i % 2 == 0 ? Eigen::Vector3d(x, 5, rng.Uniform(-1.7, 2))
                                             : Eigen::Vector3d(x, rng.Uniform(-5, 5), -1.7);
        cloud->planes.points.push_back(p.cast<float>());
        if (i % 10 == 0) cloud->edges.points.emplace_back(3.0f, -4.0f, p.cast<float>().z());
      }
      clouds.push_back(cloud);
    }
  }
  KeyframeCloudSource Source() const {
    return [this](int k) {
      ++fetched;
      return clouds.at(static_cast<size_t>(k));
    };
  }
  void Move(int centre, LoopSubmap* submap) const {
    submap->MoveTo(centre, static_cast<int>(clouds.size()), T_odom_lidar, Source(), Executor(1));
  }
};

std::set<std::tuple<double, double, double>> Occupied(const LoopSubmap& submap) {
  std::set<std::tuple<double, double, double>> set;
  for (const Eigen::Vector3d& p : submap.OccupiedCentres()) set.insert({p.x(), p.y(), p.z()});
  return set;
}

TEST(LoopSubmap, SlidingLeavesNoTrace) {
  const Street street(200);
  LoopSubmap slid{LoopSubmapOptions()}, fresh{LoopSubmapOptions()};
  for (const int centre : {30, 35, 33, 60, 90, 170, 120, 118}) street.Move(centre, &slid);
  street.Move(118, &fresh);
  EXPECT_EQ(slid.members().size(), fresh.members().size());
  EXPECT_EQ(Occupied(slid), Occupied(fresh));
  EXPECT_EQ(slid.planes().voxels(), fresh.planes().voxels());
  Rng rng(5);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(rng.Uniform(85, 150), rng.Uniform(-6, 9), rng.Uniform(-2, 4));
    const Surfel *a = slid.planes().Find(p), *b = fresh.planes().Find(p);
    ASSERT_EQ(a == nullptr, b == nullptr);
    if (a == nullptr) continue;
    ++found;
    EXPECT_EQ(a->mean, b->mean);
    EXPECT_EQ(a->axis, b->axis);
  }
  EXPECT_GT(found, 100);
}

TEST(LoopSubmap, HoldsTheKeyframesAroundAndNoneOfTheCurrentStretch) {
  const Street street(100);
  LoopSubmapOptions options;
  options.every_keyframe = 2;
  LoopSubmap submap(options);
  submap.MoveTo(50, 61, street.T_odom_lidar, street.Source(), Executor(1));
  EXPECT_EQ(submap.members().begin()->first, 26);
  EXPECT_EQ(submap.members().rbegin()->first, 60);
  EXPECT_EQ(submap.members().size(), 18u);
}

TEST(LoopSubmap, ANeighbourCostsFewClouds) {
  const Street street(100);
  LoopSubmap submap{LoopSubmapOptions()};
  street.Move(40, &submap);
  street.fetched = 0;
  street.Move(42, &submap);
  EXPECT_LE(street.fetched, 3);
}

TEST(LoopSubmap, OccupancyIsThatOfItsPoints) {
  const Street street(30);
  LoopSubmapOptions options;
  options.every_keyframe = options.every_point = 1;
  LoopSubmap submap(options);
  street.Move(10, &submap);
  std::set<std::tuple<int, int, int>> cells;
  for (size_t k = 0; k < 30; ++k) {
    for (const auto* cloud : {&street.clouds[k]->planes, &street.clouds[k]->edges}) {
      for (const Eigen::Vector3f& point : cloud->points) {
        const Eigen::Vector3d p = street.T_odom_lidar[k] * point.cast<double>();
        cells.insert({std::floor(p.x() / 0.5), std::floor(p.y() / 0.5), std::floor(p.z() / 0.5)});
      }
    }
  }
  EXPECT_EQ(Occupied(submap).size(), cells.size());
  Rng rng(8);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-10, 40), rng.Uniform(-6, 9), rng.Uniform(-2, 4));
    const bool is_in = cells.count({std::floor(p.x() / 0.5), std::floor(p.y() / 0.5),
                                    std::floor(p.z() / 0.5)}) > 0;
    EXPECT_EQ(submap.IsOccupied(p), is_in);
  }
}

TEST(LoopSubmap, WrongKeyframesAreAnError) {
  const Street street(10);
  LoopSubmap submap{LoopSubmapOptions()};
  EXPECT_THROW(submap.MoveTo(5, 5, street.T_odom_lidar, street.Source(), Executor(1)), Error);
  EXPECT_THROW(submap.MoveTo(5, 11, street.T_odom_lidar, street.Source(), Executor(1)), Error);
  LoopSubmapOptions options;
  options.every_point = 0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
