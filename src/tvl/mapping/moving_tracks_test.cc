#include "tvl/mapping/moving_tracks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::CameraAndLidar;
using synthetic::Observe;
using synthetic::Seen;

constexpr int kStanding = 40, kOnLorry = 12;
constexpr int32_t kLorry = 7;  // label of its cluster in the scan

// A street, and the corners of a lorry's back 12 m ahead.
std::vector<Eigen::Vector3d> StreetWithLorry(double lorry_moved_m) {
  std::vector<Eigen::Vector3d> corners =
      synthetic::Corners(synthetic::Street(), Rigid3d(), kStanding, 7);
  for (int i = 0; i < kOnLorry; ++i) {
    corners.emplace_back(12.0 + lorry_moved_m, 0.3 * (i % 4) - 0.5, 0.4 * (i / 4) - 0.5);
  }
  return corners;
}

bool IsOnLorry(TrackId id) { return id >= kStanding; }

// What the sensors see of it in frame k: the vehicle creeps by 5 cm a frame, the lorry by
// `speed_m`.
Seen SeeFrame(int k, double lorry_speed_m, const Rigid3d& T_world_lidar) {
  Seen seen = Observe(StreetWithLorry(lorry_speed_m * k), T_world_lidar,
                      {0.5, 0.003, 1, static_cast<uint64_t>(k + 1)});
  for (size_t i = 0; i < seen.depths.size(); ++i) {
    const bool is_lorry = IsOnLorry(seen.tracks.tracks[i].id);
    seen.depths[i].label = is_lorry ? kLorry : kFirstClusterLabel;
  }
  return seen;
}

Rigid3d Creeping(int k) { return Rigid3d::Translation(0.05 * k, 0.0, 0.0); }

int CountOnLorry(const FeatureTracks& tracks) {
  return static_cast<int>(std::count_if(tracks.tracks.begin(), tracks.tracks.end(),
                                        [](const FeatureTrack& t) { return IsOnLorry(t.id); }));
}

// Frames until all tracks on the lorry are left out; 0: never within `frames`. No other track may
// be left out.
int FramesUntilLorryIsFound(MovingTracks* moving, double lorry_speed_m, int frames) {
  for (int k = 0; k < frames; ++k) {
    Seen seen = SeeFrame(k, lorry_speed_m, Creeping(k));
    const Seen all = seen;
    const int removed = moving->Remove(&seen.tracks, &seen.depths);
    EXPECT_EQ(removed, static_cast<int>(all.depths.size() - seen.depths.size()));
    EXPECT_EQ(seen.tracks.tracks.size(), seen.depths.size());
    EXPECT_EQ(removed, CountOnLorry(all.tracks) - CountOnLorry(seen.tracks)) << "frame " << k;
    if (CountOnLorry(seen.tracks) == 0) return k;
    moving->Update(all.tracks, all.depths, Creeping(k));
  }
  return 0;
}

TEST(MovingTracks, CreepingLorryIsFoundAndNothingElse) {
  MovingTracks moving(CameraAndLidar(), {});
  const int found = FramesUntilLorryIsFound(&moving, 0.08, 20);
  EXPECT_GT(found, 0) << "never found";
  EXPECT_LE(found, 8);  // it has moved by 0.6 m then
}

TEST(MovingTracks, StandingLorryStays) {
  MovingTracks moving(CameraAndLidar(), {});
  EXPECT_EQ(FramesUntilLorryIsFound(&moving, 0.0, 60), 0);
}

TEST(MovingTracks, NewTracksOnAMovingClusterAreLeftOutAtFirstSight) {
  MovingTracks moving(CameraAndLidar(), {});
  ASSERT_GT(FramesUntilLorryIsFound(&moving, 0.08, 20), 0);
  Seen seen = SeeFrame(20, 0.08, Creeping(20));
  for (size_t i = 0; i < seen.tracks.tracks.size(); ++i) {
    TrackId& id = seen.tracks.tracks[i].id;
    if (id >= kStanding + 6) id += 1000;  // half of them are new
  }
  moving.Remove(&seen.tracks, &seen.depths);
  EXPECT_EQ(CountOnLorry(seen.tracks), 0);
  EXPECT_GT(seen.depths.size(), 20U);
}

TEST(MovingTracks, OneWrongDepthDoesNotCondemnItsCluster) {
  MovingTracks moving(CameraAndLidar(), {});
  for (int k = 0; k < 10; ++k) {
    Seen seen = SeeFrame(k, 0.0, Creeping(k));
    if (k > 2) seen.depths.back().depth_m += 1.5;  // slid to the background
    const Seen all = seen;
    moving.Remove(&seen.tracks, &seen.depths);
    if (k == 9) {
      EXPECT_EQ(CountOnLorry(seen.tracks), CountOnLorry(all.tracks) - 1);
    }
    moving.Update(all.tracks, all.depths, Creeping(k));
  }
}

TEST(MovingTracks, RefusesBadOptionsByName) {
  MovingTrackOptions options;
  options.min_cluster_share = 0.0;
  try {
    MovingTracks(CameraAndLidar(), options);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("min_cluster_share"), std::string::npos);
  }
}

}  // namespace
}  // namespace tvl
