#include "tvl/vision/pixel_prediction.h"

#include "tvl/base/check.h"

namespace tvl {

PixelPredictions PredictPixels(const FeatureTracks& tracks, const VisualDepths& depths,
                               const Rigid3d& T_cur_prev, const Camera& camera) {
  constexpr double kNearest_m = 0.5;  // nearer the projection flies off with any error
  TVL_CHECK(tracks.tracks.size() == depths.size()) << "one depth a track";
  PixelPredictions predictions;
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].status != DepthStatus::kOk) continue;
    const FeatureTrack& track = tracks.tracks[i];
    const Eigen::Vector3d p_prev = depths[i].depth_m * track.ray_cam.homogeneous();
    const Eigen::Vector3d p_cur = T_cur_prev * p_prev;
    if (p_cur.z() < kNearest_m) continue;
    predictions.push_back({track.id, camera.Project(p_cur.hnormalized())});
  }
  return predictions;
}

}  // namespace tvl
