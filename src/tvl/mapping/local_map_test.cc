#include "tvl/mapping/local_map.h"

#include <gtest/gtest.h>

#include "tvl/registration/test_surfels.h"

namespace tvl {
namespace {

using synthetic::Answered;
using synthetic::Differences;
using synthetic::RoomScan;
using synthetic::SomePose;

LocalMapMember Member(uint64_t seed, double path_m) {
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = RoomScan(seed, 2000);
  cloud->edges.points = RoomScan(seed + 1000, 300);
  return {static_cast<int>(seed), path_m, SomePose(seed), cloud};
}

LocalMap MapOf(const std::vector<LocalMapMember>& members) {
  LocalMapOptions options;
  options.keep_path_m = 1e9;
  LocalMap map(options);
  for (const LocalMapMember& member : members) map.Add(member, Executor(1));
  return map;
}

void ExpectSame(const LocalMap& a, const LocalMap& b) {
  EXPECT_EQ(a.planes().voxels(), b.planes().voxels());
  EXPECT_EQ(a.lines().voxels(), b.lines().voxels());
  EXPECT_GT(Answered(a.planes()), 100);
  EXPECT_EQ(Differences(a.planes(), b.planes()), 0);
  EXPECT_EQ(Differences(a.lines(), b.lines()), 0);
}

TEST(LocalMap, IsTheCacheOfTheKeyframesRecentByPath) {
  LocalMapOptions options;
  options.keep_path_m = 5.0;
  LocalMap map(options);
  std::vector<LocalMapMember> recent;
  for (uint64_t k = 0; k < 14; ++k) {
    map.Add(Member(k, static_cast<double>(k)), Executor(2));
    if (k >= 8) recent.push_back(Member(k, static_cast<double>(k)));
  }
  EXPECT_EQ(map.size(), 6U);
  ExpectSame(map, MapOf(recent));
}

TEST(LocalMap, TakesConnectedKeyframesAFewAtATimeAndLetsThemGo) {
  LocalMapOptions options;
  options.connected_changes = 2;
  LocalMap map(options);
  const Executor executor(1);
  map.Add(Member(9, 200.0), executor);
  const auto fetch = [](int k) { return Member(static_cast<uint64_t>(k), 0.0).cloud; };
  const std::vector<LocalMap::Connected> wanted = {
      {9, SomePose(9)}, {1, SomePose(1)}, {2, SomePose(2)}, {3, SomePose(3)}};
  map.Connect(wanted, fetch, executor);
  EXPECT_EQ(map.connected(), 2U);  // not all at once, and 9 is recent already
  map.Connect(wanted, fetch, executor);
  ExpectSame(map, MapOf({Member(9, 0), Member(1, 0), Member(2, 0), Member(3, 0)}));
  map.Connect({}, fetch, executor);
  map.Connect({}, fetch, executor);
  EXPECT_EQ(map.connected(), 0U);
  ExpectSame(map, MapOf({Member(9, 0)}));
}

TEST(LocalMap, PlacesAConnectedKeyframeAnewWhenTheGraphHasMovedIt) {
  LocalMap map{LocalMapOptions()};
  const Executor executor(1);
  map.Add(Member(9, 200.0), executor);
  const auto fetch = [](int k) { return Member(static_cast<uint64_t>(k), 0.0).cloud; };
  map.Connect({{1, SomePose(1)}}, fetch, executor);
  const Rigid3d near = SomePose(1) * Rigid3d::Translation(0.02, 0, 0);
  map.Connect({{1, near}}, fetch, executor);
  ExpectSame(map, MapOf({Member(9, 0), Member(1, 0)}));  // not worth the trouble
  const Rigid3d far = SomePose(1) * Rigid3d::Translation(0.2, 0, 0);
  map.Connect({{1, far}}, fetch, executor);
  LocalMapMember moved = Member(1, 0);
  moved.T_odom_lidar = far;
  ExpectSame(map, MapOf({Member(9, 0), moved}));
}

}  // namespace
}  // namespace tvl
