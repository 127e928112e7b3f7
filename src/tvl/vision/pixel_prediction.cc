#include "tvl/vision/pixel_prediction.h"

#include "tvl/base/check.h"
#include "tvl/vision/ground_warp.h"

namespace tvl {
namespace {

constexpr double kNearest_m = 0.5;  // nearer the projection flies off with any error
// A patch that grows by more than this changes under the optical flow's window ...
constexpr double kWarpingGrowth = 1.15;
// ... and one that grows by more than this is lost by it, or followed short. The image is warped if
// there are so many of these.
constexpr double kLostGrowth = 1.2;
constexpr int kMinLost = 10;

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
  int lost = 0;
  for (size_t i = 0; i < depths.size(); ++i) {
    const FeatureTrack& track = tracks.tracks[i];
    const double depth_m = DepthOf_m(track, depths[i], ground_inverse_m);
    const Eigen::Vector3d p_cur = T_cur_prev * (depth_m * track.ray_cam.homogeneous());
    if (depth_m <= 0.0 || p_cur.z() < kNearest_m) continue;
    const bool can_warp_here = can_warp && depths[i].label == kLabelGround;
    const bool warps = can_warp_here && depth_m > kWarpingGrowth * p_cur.z();
    lost += can_warp_here && depth_m > kLostGrowth * p_cur.z();
    predictions.pixels.push_back({track.id, camera.Project(p_cur.hnormalized()), warps});
  }
  if (lost >= kMinLost) {
    predictions.H_cur_prev_ground = PlaneHomography(*ground_inverse_m, T_cur_prev, camera);
  }
  return predictions;
}

}  // namespace tvl
