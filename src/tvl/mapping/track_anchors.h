// From where each track was first seen. Two rays to one point and the way between them lie in a
// plane, whatever the point's depth: over a whole track that holds roll and pitch, where a laser
// with errors in its beams drifts, and where depths carry those errors, too.
#pragma once

#include <map>
#include <optional>

#include "tvl/frame/feature_tracks.h"
#include "tvl/registration/visual_terms.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct TrackAnchorOptions {
  // Of a corner, and by how much a track leaves its first patch with every frame (random walk).
  // Tracks leave their epipolar planes by 0.25 px after one frame, 0.5 after 6, 0.7 after 12 and 1.0
  // to 1.3 after 24, on KITTI, KITTI-360 and simulated streets alike (1.48 x the median).
  double sigma_px = 0.2, drift_px = 0.2;
  double min_baseline_m = 2.0;  // shorter: the motion between two frames says the same
  double gate_chi2 = 16.0;      // 4 sigma: beyond, the track is anchored anew
  void Check() const;
};

class TrackAnchors {
 public:
  TrackAnchors(const Calibration& calibration, const TrackAnchorOptions& options);

  // With T_world_lidar as the unknown; none if the track's anchor is too near to T_world_guess.
  std::optional<EpipolarMatch> Match(const FeatureTrack& track, const Rigid3d& T_world_guess) const;

  // After the frame's pose is known: new tracks are anchored, those that contradict anew.
  void Update(const FeatureTracks& tracks, const Rigid3d& T_world_lidar);

  size_t size() const { return anchors_.size(); }

  // From the next call on; what is known is kept.
  void SetCalibration(const Calibration& calibration) { calibration_ = calibration; }

 private:
  struct Anchor {
    Rigid3d T_anchor_world;
    Eigen::Vector3d ray_cam;  // unit
    int age = 0;              // frames
  };
  EpipolarMatch MakeMatch(const Anchor& anchor, const FeatureTrack& track) const;

  Calibration calibration_;
  TrackAnchorOptions options_;
  std::map<TrackId, Anchor> anchors_;
};

}  // namespace tvl
