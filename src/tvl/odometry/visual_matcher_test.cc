#include "tvl/odometry/visual_matcher.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::Observe;
using synthetic::Twist;

const Rigid3d kMotion = Rigid3d::Exp(Twist(0.01, -0.02, 0.03, 1.1, 0.1, 0.0));

// Two images of the street, without noise: ids 0, 3, 6, ... have depth in the first, ids 0, 2, 4,
// ... in the second.
struct TwoImages {
  VisualFeatures previous, current;
  Calibration calibration = synthetic::CameraAndLidar();

  TwoImages() {
    const auto corners = synthetic::Corners(synthetic::Street(), kMotion, 120, 3);
    const synthetic::Seen a = Observe(corners, Rigid3d(), {0.0, 0.0, 3, 1});
    const synthetic::Seen b = Observe(corners, kMotion, {0.0, 0.0, 2, 1});
    previous = {a.tracks, a.depths};
    current = {b.tracks, b.depths};
  }
  VisualMatches Match(const Rigid3d& T) const {
    return MatchVisual(previous, current, calibration, T, VisualMatchOptions());
  }
};

bool Has(const FeatureTracks& tracks, TrackId id) {
  for (const FeatureTrack& track : tracks.tracks) {
    if (track.id == id) return true;
  }
  return false;
}

TEST(MatchVisual, TheFormFollowsFromTheKnownDepths) {
  TwoImages images;
  images.current.tracks.tracks.erase(images.current.tracks.tracks.begin() + 5);  // lost
  images.current.depths.erase(images.current.depths.begin() + 5);
  images.previous.tracks.tracks.erase(images.previous.tracks.tracks.begin() + 9);  // new
  images.previous.depths.erase(images.previous.depths.begin() + 9);
  size_t forward = 0, inverse = 0, epipolar = 0;
  for (const FeatureTrack& track : images.previous.tracks.tracks) {
    if (!Has(images.current.tracks, track.id)) continue;
    if (track.id % 3 == 0) {
      ++forward;
    } else {
      track.id % 2 == 0 ? ++inverse : ++epipolar;
    }
  }
  const VisualMatches matches = images.Match(kMotion);
  EXPECT_EQ(matches.forward.size(), forward);
  EXPECT_EQ(matches.inverse.size(), inverse);
  EXPECT_EQ(matches.epipolar.size(), epipolar);
  EXPECT_GT(std::min({forward, inverse, epipolar}), 10u);
}

TEST(MatchVisual, ResidualsVanishAtTheTruth) {
  const TwoImages images;
  const Rigid3d& T_cam_lidar = images.calibration.T_cam_lidar;
  const VisualMatches matches = images.Match(kMotion);
  for (const auto& match : matches.forward) {
    EXPECT_LT(Evaluate(match.factor, kMotion, T_cam_lidar).r.norm(), 1e-12);
    EXPECT_GT(Evaluate(match.factor, Rigid3d(), T_cam_lidar).r.norm(), 1e-4);
  }
  for (const auto& match : matches.inverse) {
    EXPECT_LT(Evaluate(match.factor, kMotion, T_cam_lidar).r.norm(), 1e-12);
  }
  for (const auto& match : matches.epipolar) {
    EXPECT_LT(Evaluate(match.factor, kMotion, T_cam_lidar, T_cam_lidar.Adjoint()).r.norm(), 1e-12);
  }
}

TEST(MatchVisual, NoEpipolarPlanesWithoutABaseline) {
  const TwoImages images;
  EXPECT_TRUE(images.Match(Rigid3d::Translation(0.05, 0, 0)).epipolar.empty());
  EXPECT_FALSE(images.Match(Rigid3d::Translation(1.0, 0, 0)).epipolar.empty());
}

TEST(MatchVisual, VagueDepthsCountAsNone) {
  TwoImages images;
  for (VisualFeatures* features : {&images.previous, &images.current}) {
    for (VisualDepth& depth : features->depths) depth.sigma_m = 0.3 * depth.depth_m;
  }
  const VisualMatches matches = images.Match(kMotion);
  EXPECT_TRUE(matches.forward.empty() && matches.inverse.empty());
  EXPECT_GT(matches.epipolar.size(), 50u);
}

TEST(MatchVisual, AnUncertainDepthWeighsLess) {
  TwoImages images;
  const VisualMatches sharp = images.Match(kMotion);
  for (VisualDepth& depth : images.previous.depths) depth.sigma_m = 0.1 * depth.depth_m;
  const VisualMatches vague = images.Match(kMotion);
  ASSERT_EQ(sharp.forward.size(), vague.forward.size());
  for (size_t i = 0; i < sharp.forward.size(); ++i) {
    EXPECT_LE(vague.forward[i].information.determinant(),
              sharp.forward[i].information.determinant() * 1.0001);
  }
}

TEST(VisualMatchOptions, NameTheBadField) {
  VisualMatchOptions options;
  options.sigma_px = -1.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
