#include "tvl/mapping/moving_tracks.h"

#include <Eigen/LU>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/mapping/track_point.h"

namespace tvl {

void MovingTrackOptions::Check() const {
  TVL_CHECK_INPUT(sigma_px > 0.0) << "moving_tracks.sigma_px: must be positive";
  TVL_CHECK_INPUT(gate_sigmas > 0.0) << "moving_tracks.gate_sigmas: must be positive";
  TVL_CHECK_INPUT(min_motion_m >= 0.0) << "moving_tracks.min_motion_m: must not be negative";
  TVL_CHECK_INPUT(drift_share >= 0.0) << "moving_tracks.drift_share: must not be negative";
  TVL_CHECK_INPUT(drift_rad >= 0.0) << "moving_tracks.drift_rad: must not be negative";
  TVL_CHECK_INPUT(min_frames >= 1) << "moving_tracks.min_frames: must be at least 1";
  TVL_CHECK_INPUT(min_cluster_tracks >= 1)
      << "moving_tracks.min_cluster_tracks: must be at least 1";
  TVL_CHECK_INPUT(min_cluster_share > 0.0 && min_cluster_share <= 1.0)
      << "moving_tracks.min_cluster_share: must lie in 0..1";
  TVL_CHECK_INPUT(min_cluster_accord >= 0.0 && min_cluster_accord <= 1.0)
      << "moving_tracks.min_cluster_accord: must lie in 0..1";
}

MovingTracks::MovingTracks(const Calibration& calibration, const MovingTrackOptions& options)
    : calibration_(calibration), options_(options) {
  options_.Check();
}

std::set<int32_t> MovingTracks::MovingClusters(const FeatureTracks& tracks,
                                               const VisualDepths& depths) const {
  struct Votes {
    int judged = 0, moving = 0;
    double lengths_m = 0.0;
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  };
  std::map<int32_t, Votes> clusters;
  for (size_t i = 0; i < tracks.tracks.size(); ++i) {
    const auto found = places_.find(tracks.tracks[i].id);
    if (depths[i].label < kFirstClusterLabel || found == places_.end()) continue;
    const Place& place = found->second;
    if (place.frames < options_.min_frames) continue;
    Votes& votes = clusters[depths[i].label];
    ++votes.judged;
    if (!place.moves) continue;
    ++votes.moving;
    votes.sum_m += place.motion_m;
    votes.lengths_m += place.motion_m.norm();
  }
  std::set<int32_t> moving;
  for (const auto& [label, votes] : clusters) {
    if (votes.judged >= options_.min_cluster_tracks &&
        votes.moving >= options_.min_cluster_share * votes.judged &&
        votes.sum_m.norm() >= options_.min_cluster_accord * votes.lengths_m) {
      moving.insert(label);
    }
  }
  return moving;
}

int MovingTracks::Remove(FeatureTracks* tracks, VisualDepths* depths) {
  TVL_CHECK(tracks->tracks.size() == depths->size()) << "one depth a track";
  const std::set<int32_t> clusters = MovingClusters(*tracks, *depths);
  std::map<TrackId, Place> known;
  size_t kept = 0;
  for (size_t i = 0; i < depths->size(); ++i) {
    const auto found = places_.find(tracks->tracks[i].id);
    const bool moves = found != places_.end() && found->second.moves;
    if (found != places_.end()) known.insert(*found);
    if (moves || clusters.count((*depths)[i].label) > 0) continue;
    tracks->tracks[kept] = tracks->tracks[i];
    (*depths)[kept] = (*depths)[i];
    ++kept;
  }
  const int removed = static_cast<int>(depths->size() - kept);
  tracks->tracks.resize(kept);
  depths->resize(kept);
  places_ = std::move(known);
  return removed;
}

MovingTracks::Place MovingTracks::Locate(const FeatureTrack& track, const VisualDepth& depth,
                                         const Rigid3d& T_world_lidar) const {
  const double sigma_rad =
      std::hypot(options_.sigma_px / calibration_.camera.fx_px, options_.drift_rad);
  const TrackPoint point =
      LocateTrack(track, depth, sigma_rad, T_world_lidar * calibration_.T_cam_lidar.Inverse());
  return {point.p_world, point.covariance_m2, path_m_};
}

void MovingTracks::Judge(const Place& now, Place* place) const {
  const double drift_m = options_.drift_share * (now.path_m - place->path_m);
  const Eigen::Matrix3d covariance =
      place->covariance_m2 + now.covariance_m2 + drift_m * drift_m * Eigen::Matrix3d::Identity();
  place->motion_m = now.p_world - place->p_world;
  const double chi2 = place->motion_m.dot(covariance.inverse() * place->motion_m);
  const bool is_outside = chi2 > options_.gate_sigmas * options_.gate_sigmas &&
                          place->motion_m.norm() > options_.min_motion_m;
  ++place->frames;
  place->outside = is_outside ? place->outside + 1 : 0;
  place->moves = place->moves || place->outside >= options_.min_frames;
}

void MovingTracks::Update(const FeatureTracks& tracks, const VisualDepths& depths,
                          const Rigid3d& T_world_lidar) {
  path_m_ += (T_world_lidar.t() - t_world_last_).norm();
  t_world_last_ = T_world_lidar.t();
  for (size_t i = 0; i < tracks.tracks.size(); ++i) {
    if (depths[i].status != DepthStatus::kOk) continue;
    const Place now = Locate(tracks.tracks[i], depths[i], T_world_lidar);
    const auto [place, is_new] = places_.try_emplace(tracks.tracks[i].id, now);
    if (!is_new) Judge(now, &place->second);
  }
}

}  // namespace tvl
