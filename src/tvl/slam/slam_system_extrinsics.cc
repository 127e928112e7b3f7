// The part of SlamSystem that keeps and uses what is known of where the camera points.
#include <memory>
#include <optional>

#include "tvl/slam/slam_system.h"

namespace tvl {

// What was placed with other extrinsics is let go of.
void SlamSystem::CalibrateExtrinsics(const PreprocessedFrame& frame,
                                     const FeatureTracks& all_tracks, const FoundPose& found,
                                     const Executor& executor, FrameResult* result) {
  const Rigid3d& T_odom_lidar = result->T_odom_lidar;
  // With all tracks: a wrong calibration makes all that stands seem to move.
  const std::string odd = calibration_check_.Add(all_tracks, T_odom_lidar);
  if (!odd.empty()) {
    result->faults.push_back(
        {FrameFault::Kind::kOddCalibration, "frame " + std::to_string(frame.id) + ": " + odd});
  }
  const Rigid3d T_image =
      Rigid3d::Exp(ImageDelay_s() * last_motion_.Velocity_lidar());  // since the scan
  bool has_changed = extrinsics_.Add(frame.tracks, T_odom_lidar * T_image);
  if (CheckExtrinsics(frame, found, T_image, executor)) has_changed = true;
  // Read with the extrinsics in use: not in the frame in which they change.
  if (!has_changed && frame.has_image && frame.has_scan && extrinsics_.WantsEdges(T_odom_lidar)) {
    has_changed = extrinsics_.AddEdges(
        preprocessor_.FindEdges(frame, last_motion_, options_.extrinsics.edges.max_edges));
  }
  if (has_changed) {  // camera 0 is turned with the one that is used: they sit on one frame
    Calibration& calibration = setup_.calibration;
    const Rigid3d T_cam0_cam = calibration.T_cam0_lidar * calibration.T_cam_lidar.Inverse();
    calibration.T_cam_lidar = extrinsics_.T_cam_lidar();
    calibration.T_cam0_lidar = T_cam0_cam * calibration.T_cam_lidar;
  }
  UseExtrinsics();
  if (!has_changed) return;
  landmarks_ = LandmarkMap(setup_.calibration, options_.mapping.landmarks);
  moving_tracks_ = MovingTracks(setup_.calibration, options_.mapping.moving_tracks);
}

bool SlamSystem::CheckExtrinsics(const PreprocessedFrame& frame, const FoundPose& found,
                                 const Rigid3d& T_image, const Executor& executor) {
  const bool has_camera = setup_.has_camera && !calibration_check_.has_contradiction();
  if (!has_camera || !extrinsics_.WantsLidarOnly()) {
    lidar_only_.Forget();
    return false;
  }
  if (!frame.has_scan || found.tracked.cloud.planes.points.empty()) return false;
  const auto cloud = std::make_shared<const KeyframeCloud>(found.tracked.cloud);
  const MapStepPoints points =
      PointsForMapStep(*cloud, frame, setup_.lidar, options_.mapping.scan_to_map.source_voxel_m);
  const std::optional<LidarPose> pose =
      lidar_only_.Add(points, cloud, found.tracked.T_odom_lidar, executor);
  if (!pose) {
    extrinsics_.ForgetLidarOnly();
    return false;
  }
  return extrinsics_.AddLidarOnly(frame.tracks, {pose->T_odom_lidar * T_image, pose->covariance});
}

void SlamSystem::ForgetViews() {
  moving_tracks_.Forget();
  extrinsics_.Forget();
  lidar_only_.Forget();
  calibration_check_.Forget();
}

void SlamSystem::UseExtrinsics() {
  if (!options_.extrinsics.enabled) return;
  setup_.calibration.rotation_covariance = extrinsics_.RemainingError();
  preprocessor_.SetCalibration(setup_.calibration);
  finder_.SetCalibration(setup_.calibration);
}

void SlamSystem::UseDelay(const PredictedMotion& motion) {
  const double delay_s = ImageDelay_s();
  if (delay_s == 0.0 && !is_delayed_) return;
  is_delayed_ = delay_s != 0.0;
  const Calibration delayed = Delayed(setup_.calibration, delay_s, motion.Velocity_lidar());
  preprocessor_.SetCalibration(delayed);
  finder_.SetCalibration(delayed);
  landmarks_.SetCalibration(delayed);
  moving_tracks_.SetCalibration(delayed);
}

}  // namespace tvl
