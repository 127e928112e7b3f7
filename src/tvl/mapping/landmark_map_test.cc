#include "tvl/mapping/landmark_map.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::CameraAndLidar;
using synthetic::Observe;
using synthetic::Seen;
using synthetic::Twist;

constexpr synthetic::CameraNoise kNoNoise{0.0, 0.0, 1, 1};

std::vector<Eigen::Vector3d> StreetCorners(int count) {
  return synthetic::Corners(synthetic::Street(), Rigid3d(), count, 7);
}

LandmarkMap MakeMap() { return LandmarkMap(CameraAndLidar(), LandmarkOptions()); }

void Update(LandmarkMap& map, const Seen& seen, const Rigid3d& T_world_lidar) {
  map.Update(seen.tracks, seen.depths, T_world_lidar);
}

TEST(LandmarkMap, AnchoredPointsFitExactlyAtTheTruth) {
  const auto corners = StreetCorners(60);
  const Rigid3d T_anchor = Rigid3d::Exp(Twist(0.02, -0.01, 0.1, 3.0, 1.0, 0.2));
  const Rigid3d T_later = T_anchor * Rigid3d::Exp(Twist(0.01, 0.01, -0.03, 1.5, 0.1, 0.0));
  LandmarkMap map = MakeMap();
  Update(map, Observe(corners, T_anchor, kNoNoise), T_anchor);
  const Seen later = Observe(corners, T_later, kNoNoise);
  const auto matches = map.Match(later.tracks, T_later);
  ASSERT_GT(matches.size(), 20u);
  for (const ReprojectionMatch& match : matches) {
    EXPECT_LT(Chi2(match, T_later, CameraAndLidar().T_cam_lidar), 1e-12);
    EXPECT_GT(Chi2(match, T_anchor, CameraAndLidar().T_cam_lidar), 1.0);
    const TrackId id = later.tracks.tracks[match.source].id;
    EXPECT_LT((match.factor.p_ref - corners[static_cast<size_t>(id)]).norm(), 1e-9);
  }
}

TEST(LandmarkMap, OnlyTracksWithGoodDepthBecomeLandmarks) {
  const auto corners = StreetCorners(30);
  Seen seen = Observe(corners, Rigid3d(), {0.0, 0.0, 3, 1});
  LandmarkMap map = MakeMap();
  Update(map, seen, Rigid3d());
  EXPECT_EQ(map.size(), 10u);
  for (VisualDepth& depth : seen.depths) {
    if (depth.status == DepthStatus::kOk) {
      depth.sigma_m = 1.2 * LandmarkOptions().max_relative_sigma * depth.depth_m;
    }
  }
  LandmarkMap other = MakeMap();
  Update(other, seen, Rigid3d());
  EXPECT_EQ(other.size(), 0u);
}

TEST(LandmarkMap, VanishedTracksLeave) {
  const auto corners = StreetCorners(30);
  Seen seen = Observe(corners, Rigid3d(), kNoNoise);
  LandmarkMap map = MakeMap();
  Update(map, seen, Rigid3d());
  EXPECT_EQ(map.size(), 30u);
  seen.tracks.tracks.resize(12);
  seen.depths.resize(12);
  Update(map, seen, Rigid3d());
  EXPECT_EQ(map.size(), 12u);
  Update(map, Seen(), Rigid3d());
  EXPECT_EQ(map.size(), 0u);
}

TEST(LandmarkMap, AMovingPointIsGivenUpAndStaticOnesStay) {
  auto corners = StreetCorners(20);
  const Rigid3d step = Rigid3d::Translation(0.3, 0, 0);
  LandmarkMap map = MakeMap();
  Update(map, Observe(corners, Rigid3d(), kNoNoise), Rigid3d());
  ASSERT_EQ(map.size(), 20u);
  Rigid3d T;
  const int frames = LandmarkOptions().max_rejections + 2;
  for (int k = 0; k < frames; ++k) {
    T = T * step;
    corners[4] += Eigen::Vector3d(0.0, 0.5, 0.5);
    Update(map, Observe(corners, T, {0.0, 0.0, 0, 1}), T);  // no depth: no second chance
  }
  const auto matches = map.Match(Observe(corners, T, kNoNoise).tracks, T);
  EXPECT_GE(matches.size(), 15u);
  for (const ReprojectionMatch& match : matches) {
    EXPECT_GT((match.factor.p_ref - corners[4]).norm(), 3.0) << "the moving point is still there";
    EXPECT_LT(Chi2(match, T, CameraAndLidar().T_cam_lidar), 1e-12);
  }
}

TEST(LandmarkMap, ASingleBadObservationIsForgiven) {
  auto corners = StreetCorners(10);
  const Seen good = Observe(corners, Rigid3d(), {0.0, 0.0, 1, 1});
  LandmarkMap map = MakeMap();
  Update(map, good, Rigid3d());
  Seen bad = Observe(corners, Rigid3d(), {0.0, 0.0, 0, 1});
  bad.tracks.tracks[3].ray_cam.x() += 0.05;
  for (int k = 0; k < 6; ++k) {  // never twice in a row
    Update(map, bad, Rigid3d());
    Update(map, Observe(corners, Rigid3d(), {0.0, 0.0, 0, 1}), Rigid3d());
  }
  EXPECT_EQ(map.size(), 10u);
}

TEST(LandmarkMap, ABetterDepthReplacesTheAnchor) {
  const auto corners = StreetCorners(10);
  Seen seen = Observe(corners, Rigid3d(), kNoNoise);
  for (VisualDepth& depth : seen.depths) {  // wrong by 4 %, and known to be vague
    depth.sigma_m = 0.08 * depth.depth_m;
    depth.depth_m *= 1.04;
  }
  LandmarkMap map = MakeMap();
  Update(map, seen, Rigid3d());
  const auto vague = map.Match(seen.tracks, Rigid3d());
  Seen sharp = Observe(corners, Rigid3d(), kNoNoise);
  for (VisualDepth& depth : sharp.depths) depth.sigma_m = 0.01 * depth.depth_m;
  Update(map, sharp, Rigid3d());
  const auto better = map.Match(sharp.tracks, Rigid3d());
  ASSERT_EQ(better.size(), 10u);
  for (size_t i = 0; i < better.size(); ++i) {
    EXPECT_GT((vague[i].factor.p_ref - corners[i]).norm(), 0.1);
    EXPECT_LT((better[i].factor.p_ref - corners[i]).norm(), 1e-9);
  }
  Update(map, seen, Rigid3d());  // a vaguer one does not
  EXPECT_LT((map.Match(sharp.tracks, Rigid3d())[0].factor.p_ref - corners[0]).norm(), 1e-9);
}

TEST(LandmarkMap, PointsBehindTheGuessSayNothing) {
  const auto corners = StreetCorners(5);
  const Seen seen = Observe(corners, Rigid3d(), kNoNoise);
  LandmarkMap map = MakeMap();
  Update(map, seen, Rigid3d());
  for (const auto& match : map.Match(seen.tracks, Rigid3d::Translation(100, 0, 0))) {
    EXPECT_EQ(match.information.norm(), 0.0);
  }
}

TEST(LandmarkOptions, NameTheBadField) {
  LandmarkOptions options;
  options.sigma_px = 0.0;
  EXPECT_THROW(LandmarkMap(CameraAndLidar(), options), InputError);
}

}  // namespace
}  // namespace tvl
