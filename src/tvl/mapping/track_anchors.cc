#include "tvl/mapping/track_anchors.h"

#include <cmath>

#include "tvl/base/check.h"

namespace tvl {

void TrackAnchorOptions::Check() const {
  TVL_CHECK_INPUT(sigma_px > 0.0) << "mapping.landmarks.anchors.sigma_px: must be positive";
  TVL_CHECK_INPUT(drift_px >= 0.0) << "mapping.landmarks.anchors.drift_px: must not be negative";
  TVL_CHECK_INPUT(min_baseline_m > 0.0) << "mapping.landmarks.anchors.min_baseline_m: must be positive";
  TVL_CHECK_INPUT(gate_chi2 > 0.0) << "mapping.landmarks.anchors.gate_chi2: must be positive";
}

TrackAnchors::TrackAnchors(const Calibration& calibration, const TrackAnchorOptions& options)
    : calibration_(calibration), options_(options) {
  options_.Check();
}

EpipolarMatch TrackAnchors::MakeMatch(const Anchor& anchor, const FeatureTrack& track) const {
  // The noise of a corner in both rays, and the patch has wandered between them.
  const double variance_px2 = options_.sigma_px * options_.sigma_px +
                              0.5 * options_.drift_px * options_.drift_px * anchor.age;
  const double fx_px = calibration_.camera.fx_px;
  return {{track.ray_cam.homogeneous().normalized(), anchor.ray_cam},
          fx_px * fx_px / variance_px2,
          anchor.T_anchor_world};
}

std::optional<EpipolarMatch> TrackAnchors::Match(const FeatureTrack& track,
                                                 const Rigid3d& T_world_guess) const {
  const auto found = anchors_.find(track.id);
  if (found == anchors_.end()) return std::nullopt;
  const Rigid3d T_anchor_guess = found->second.T_anchor_world * T_world_guess;
  if (T_anchor_guess.t().norm() < options_.min_baseline_m) return std::nullopt;
  return MakeMatch(found->second, track);
}

void TrackAnchors::Update(const FeatureTracks& tracks, const Rigid3d& T_world_lidar) {
  std::map<TrackId, Anchor> kept;
  for (const FeatureTrack& track : tracks.tracks) {
    const auto found = anchors_.find(track.id);
    if (found != anchors_.end()) {
      Anchor anchor = found->second;
      ++anchor.age;
      const Rigid3d T_anchor_lidar = anchor.T_anchor_world * T_world_lidar;
      if (T_anchor_lidar.t().norm() < options_.min_baseline_m ||
          Chi2(MakeMatch(anchor, track), T_world_lidar, calibration_.T_cam_lidar) <
              options_.gate_chi2) {
        kept[track.id] = anchor;
        continue;
      }
    }
    kept[track.id] = {T_world_lidar.Inverse(), track.ray_cam.homogeneous().normalized(), 0};
  }
  anchors_ = std::move(kept);
}

}  // namespace tvl
