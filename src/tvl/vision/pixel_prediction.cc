#include "tvl/vision/pixel_prediction.h"

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/vision/ground_warp.h"

namespace tvl {
namespace {

constexpr double kNearest_m = 0.5;  // nearer the projection flies off with any error
// A patch that grows by more than this changes under the optical flow's window.
constexpr double kWarpingGrowth = 1.15;
// Fewer are not worth warping the image for.
constexpr int kMinWarping = 10;

// Depth of a track: as measured, or that of the ground's plane; 0: not known.
double DepthOf_m(const FeatureTrack& track, const VisualDepth& depth,
                 const std::optional<Eigen::Vector3d>& ground_inverse_m) {
  if (depth.status == DepthStatus::kOk) return depth.depth_m;
  if (depth.label != kLabelGround || !ground_inverse_m) return 0.0;
  const double inverse_depth_m = ground_inverse_m->dot(track.ray_cam.homogeneous());
  return inverse_depth_m > 0.0 ? 1.0 / inverse_depth_m : 0.0;
}

}  // namespace

PixelPredictions PredictPixels(const FeatureTracks& tracks, const VisualDepths& depths,
                               const Rigid3d& T_cur_prev, const Camera& camera) {
  TVL_CHECK(tracks.tracks.size() == depths.size()) << "one depth a track";
  const std::optional<Eigen::Vector3d> ground_inverse_m = FitGroundPlane(tracks, depths);
  const bool can_warp = ground_inverse_m && !camera.IsDistorted();
  PixelPredictions predictions;
  for (size_t i = 0; i < depths.size(); ++i) {
    const FeatureTrack& track = tracks.tracks[i];
    const double depth_m = DepthOf_m(track, depths[i], ground_inverse_m);
    const Eigen::Vector3d p_cur = T_cur_prev * (depth_m * track.ray_cam.homogeneous());
    if (depth_m <= 0.0 || p_cur.z() < kNearest_m) continue;
    const bool warps =
        can_warp && depths[i].label == kLabelGround && depth_m > kWarpingGrowth * p_cur.z();
    predictions.pixels.push_back({track.id, camera.Project(p_cur.hnormalized()), warps});
  }
  const auto warping = std::count_if(predictions.pixels.begin(), predictions.pixels.end(),
                                     [](const PixelPrediction& pixel) { return pixel.warps; });
  if (warping >= kMinWarping) {
    predictions.H_cur_prev_ground = PlaneHomography(*ground_inverse_m, T_cur_prev, camera);
  }
  return predictions;
}

}  // namespace tvl
