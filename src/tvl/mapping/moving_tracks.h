// Tells visual tracks on moving things from those on standing ones (paper 4.1 leaves this to
// RANSAC, which follows the majority: in a traffic jam that is the traffic).
//
// A track whose depth the lidar knows has a place in the world in every frame. That of a standing
// thing stays, as far as noise and the drift of the pose allow. A track that leaves its place is on
// something that moves, and where most judged tracks of a cluster of the scan do so together, the
// whole cluster moves, with the tracks on it that are too new to be judged.
#pragma once

#include <map>
#include <set>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct MovingTrackOptions {
  double sigma_px = 0.6;     // of a tracked corner, one standard deviation
  double gate_sigmas = 4.0;  // beyond, a track has left its place
  // A track that has moved by less stands: sub-pixel errors and rough surfaces do as much.
  double min_motion_m = 0.15;
  double drift_share = 0.01;       // of the way driven since: error of the pose
  double drift_rad = 0.002;        // of the pose's attitude, whatever the way
  int min_frames = 2;              // in a row beyond the gate
  int min_cluster_tracks = 3;      // judged ones, for a verdict on their cluster
  double min_cluster_share = 0.5;  // of them must move, and
  double min_cluster_accord =
      0.7;             // the sum of their motions is this share of the motions' lengths
  void Check() const;  // throws InputError naming the field
};

class MovingTracks {
 public:
  MovingTracks(const Calibration& calibration, const MovingTrackOptions& options);

  // Takes the tracks on moving things out of a frame, with their depths. `tracks` holds all that
  // the vision follows: what is known of others is forgotten. Returns how many were taken out.
  int Remove(FeatureTracks* tracks, VisualDepths* depths);

  // After the frame's pose is known, with the tracks that Remove left and with those it took.
  void Update(const FeatureTracks& tracks, const VisualDepths& depths,
              const Rigid3d& T_world_lidar);

  // After poses that do not continue those before: all places are unknown.
  void Forget() { places_.clear(); }

  // From the next call on; what is known is kept.
  void SetCalibration(const Calibration& calibration) { calibration_ = calibration; }

 private:
  // Where a track was first seen with a depth, and what became of it.
  struct Place {
    Eigen::Vector3d p_world;
    Eigen::Matrix3d covariance_m2;
    double path_m = 0.0;  // of the vehicle then
    Eigen::Vector3d motion_m = Eigen::Vector3d::Zero();
    int frames = 0;   // judged
    int outside = 0;  // beyond the gate, in a row
    bool moves = false;
  };
  Place Locate(const FeatureTrack& track, const VisualDepth& depth,
               const Rigid3d& T_world_lidar) const;
  void Judge(const Place& now, Place* place) const;
  std::set<int32_t> MovingClusters(const FeatureTracks& tracks, const VisualDepths& depths) const;

  Calibration calibration_;
  MovingTrackOptions options_;
  std::map<TrackId, Place> places_;
  double path_m_ = 0.0;
  Eigen::Vector3d t_world_last_ = Eigen::Vector3d::Zero();
};

}  // namespace tvl
