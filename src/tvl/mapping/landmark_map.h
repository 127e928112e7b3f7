// Visual landmarks: tracks whose depth the lidar knew once, held fixed in the world. They keep the
// camera's say in the map step, where a tunnel's walls say nothing of the way along it.
#pragma once

#include <map>
#include <vector>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/registration/visual_terms.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct LandmarkOptions {
  double sigma_px = 0.6;   // of a tracked corner, one standard deviation
  double drift_px = 0.05;  // a track leaves its first patch by this each frame (random walk)
  double max_relative_sigma = 0.1;  // of the depth: vaguer points are not made landmarks
  double reanchor_share = 0.6;      // a new depth replaces the old point if its sigma is this share
  double gate_chi2 = 16.0;          // 4 sigma: beyond, the observation is not believed
  int max_rejections = 2;           // in a row: then the landmark moves, or never was a point
  void Check() const;
};

class LandmarkMap {
 public:
  LandmarkMap(const Calibration& calibration, const LandmarkOptions& options);

  // Matches of the current tracks with landmarks, for T_world_lidar as the unknown; the guess only
  // weighs them. `source` is the index of the track.
  std::vector<ReprojectionMatch> Match(const FeatureTracks& tracks,
                                       const Rigid3d& T_world_guess) const;

  // From where the tracks' landmarks were placed, on average: a lidar position, world, m. Where
  // none is known: `otherwise_m`.
  Eigen::Vector3d MeanAnchor_m(const FeatureTracks& tracks,
                               const Eigen::Vector3d& otherwise_m) const;

  // After the frame's pose is known: drops what vanished or contradicts, adds what has depth.
  void Update(const FeatureTracks& tracks, const VisualDepths& depths,
              const Rigid3d& T_world_lidar);

  size_t size() const { return landmarks_.size(); }

  // From the next call on; what is known is kept.
  void SetCalibration(const Calibration& calibration) { calibration_ = calibration; }

 private:
  struct Landmark {
    Eigen::Vector3d p_world;
    Eigen::Matrix3d covariance_m2;  // world
    double depth_sigma_m;
    Eigen::Vector3d anchor_m;  // lidar position from where it was placed, world
    int age = 0;               // frames since it was anchored
    int rejections = 0;        // in a row
  };
  Landmark Anchor(const FeatureTrack& track, const VisualDepth& depth,
                  const Rigid3d& T_world_lidar) const;
  ReprojectionMatch MakeMatch(const Landmark& landmark, const FeatureTrack& track, size_t source,
                              const Rigid3d& T_world_lidar) const;

  Calibration calibration_;
  LandmarkOptions options_;
  std::map<TrackId, Landmark> landmarks_;
};

}  // namespace tvl
