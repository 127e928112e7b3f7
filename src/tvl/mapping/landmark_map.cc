#include "tvl/mapping/landmark_map.h"

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/mapping/track_point.h"

namespace tvl {

void LandmarkOptions::Check() const {
  TVL_CHECK_INPUT(sigma_px > 0.0) << "landmark.sigma_px: must be positive";
  TVL_CHECK_INPUT(drift_px >= 0.0) << "landmark.drift_px: must not be negative";
  TVL_CHECK_INPUT(max_relative_sigma > 0.0) << "landmark.max_relative_sigma: must be positive";
  TVL_CHECK_INPUT(gate_chi2 > 0.0) << "landmark.gate_chi2: must be positive";
  TVL_CHECK_INPUT(max_rejections >= 0) << "landmark.max_rejections: must not be negative";
}

LandmarkMap::LandmarkMap(const Calibration& calibration, const LandmarkOptions& options)
    : calibration_(calibration), options_(options) {
  options_.Check();
}

ReprojectionMatch LandmarkMap::MakeMatch(const Landmark& landmark, const FeatureTrack& track,
                                         size_t source, const Rigid3d& T_world_lidar) const {
  const Rigid3d T_cam_world = calibration_.T_cam_lidar * T_world_lidar.Inverse();
  const Eigen::Vector3d p_cam = T_cam_world * landmark.p_world;
  const double sigma_px = std::hypot(
      options_.sigma_px, options_.drift_px * std::sqrt(static_cast<double>(landmark.age)));
  ReprojectionMatch match;
  match.factor = {landmark.p_world, track.ray_cam};
  match.source = source;
  match.information = Eigen::Matrix2d::Zero();
  if (p_cam.z() > kMinProjectionDepth_m) {
    match.information =
        RayInformation(sigma_px / calibration_.camera.fx_px,
                       ProjectionJacobian(p_cam) * T_cam_world.R(), landmark.covariance_m2);
  }
  return match;
}

std::vector<ReprojectionMatch> LandmarkMap::Match(const FeatureTracks& tracks,
                                                  const Rigid3d& T_world_guess) const {
  std::vector<ReprojectionMatch> matches;
  for (size_t i = 0; i < tracks.tracks.size(); ++i) {
    const auto found = landmarks_.find(tracks.tracks[i].id);
    if (found == landmarks_.end()) continue;
    matches.push_back(MakeMatch(found->second, tracks.tracks[i], i, T_world_guess));
  }
  return matches;
}

Eigen::Vector3d LandmarkMap::MeanAnchor_m(const FeatureTracks& tracks,
                                          const Eigen::Vector3d& otherwise_m) const {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  int count = 0;
  for (const FeatureTrack& track : tracks.tracks) {
    const auto found = landmarks_.find(track.id);
    if (found == landmarks_.end()) continue;
    sum_m += found->second.anchor_m;
    ++count;
  }
  return count == 0 ? otherwise_m : Eigen::Vector3d(sum_m / count);
}

LandmarkMap::Landmark LandmarkMap::Anchor(const FeatureTrack& track, const VisualDepth& depth,
                                          const Rigid3d& T_world_lidar) const {
  const TrackPoint point = LocateTrack(track, depth, options_.sigma_px / calibration_.camera.fx_px,
                                       T_world_lidar * calibration_.T_cam_lidar.Inverse());
  return {point.p_world, point.covariance_m2, depth.sigma_m, T_world_lidar.t()};
}

void LandmarkMap::Update(const FeatureTracks& tracks, const VisualDepths& depths,
                         const Rigid3d& T_world_lidar) {
  std::map<TrackId, Landmark> kept;
  for (size_t i = 0; i < tracks.tracks.size(); ++i) {
    const FeatureTrack& track = tracks.tracks[i];
    const bool has_depth = depths[i].status == DepthStatus::kOk &&
                           depths[i].sigma_m < options_.max_relative_sigma * depths[i].depth_m;
    const auto found = landmarks_.find(track.id);
    if (found == landmarks_.end()) {
      if (has_depth) kept[track.id] = Anchor(track, depths[i], T_world_lidar);
      continue;
    }
    Landmark landmark = found->second;
    ++landmark.age;
    const double chi2 =
        Chi2(MakeMatch(landmark, track, i, T_world_lidar), T_world_lidar, calibration_.T_cam_lidar);
    landmark.rejections = chi2 > options_.gate_chi2 ? landmark.rejections + 1 : 0;
    if (landmark.rejections > options_.max_rejections) continue;
    if (has_depth && depths[i].sigma_m < options_.reanchor_share * landmark.depth_sigma_m) {
      landmark = Anchor(track, depths[i], T_world_lidar);
    }
    kept[track.id] = landmark;
  }
  landmarks_ = std::move(kept);
}

}  // namespace tvl
