// From a preprocessed frame and an expected motion to a pose: odometry (paper 5.1), compensation of
// the scan, and the map step (paper 5.2). Follows one hypothesis of the motion to its end; which of
// several is right is decided by the caller (pose_search.h), by how the scan then lies on the map.
#pragma once

#include "tvl/base/parallel.h"
#include "tvl/map/keyframe.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/local_map.h"
#include "tvl/mapping/map_fit.h"
#include "tvl/mapping/scan_to_map.h"
#include "tvl/odometry/visual_lidar_odometry.h"
#include "tvl/sensor/dataset.h"
#include "tvl/slam/motion_model.h"
#include "tvl/slam/slam_options.h"
#include "tvl/slam/stage_times.h"

namespace tvl {

// What a frame is registered against besides the previous one.
struct TrackingReference {
  Rigid3d T_odom_prev;
  const LocalMap& map;
  const LandmarkMap& landmarks;
  bool map_step_is_due = true;
};

// Where a frame may be.
struct PoseHypothesis {
  Rigid3d T_odom_lidar;
  Matrix6d covariance = Matrix6d::Identity();  // right perturbation, [rotation, translation]
  // The motion since the previous frame: moves the points of a raw sweep and, where the previous
  // frame's pose is known, is where odometry begins.
  MotionPrediction motion;
  bool use_odometry = true;

  static PoseHypothesis Of(const MotionPrediction& motion, const Rigid3d& T_odom_prev) {
    return {T_odom_prev * motion.T_prev_cur, motion.covariance, motion, true};
  }
};

// A hypothesis, followed to its end.
struct TrackedPose {
  MotionPrediction start;    // the hypothesis's motion
  MotionEstimate odometry;   // T_ref_body = T_{k-1,k}
  ScanToMapResult map_step;  // in the odometry frame; status kFirst where it did not run
  Rigid3d T_odom_lidar;
  Matrix6d step_covariance = Matrix6d::Zero();  // of T_{k-1,k}, right perturbation
  bool is_measured = false;  // by odometry or map step; false: the pose is the prediction
  KeyframeCloud cloud;       // F_ls, F_lf compensated by the motion found
  std::vector<uint32_t> map_step_source;  // of each plane match: index into F_lf
  MapFit fit;                             // of what stands above the ground, at T_odom_lidar
  KnownFit known_fit;                     // without what the map cannot know

  Rigid3d Motion(const Rigid3d& T_odom_prev) const { return T_odom_prev.Inverse() * T_odom_lidar; }
};

// Whether lidar or camera hold every direction of the pose.
bool HoldsAllDirections(const TrackedPose& tracked);
// Whether the step's error along a direction that nothing but prediction holds may exceed what a
// claim to be measured allows (a third of 0.3 m and 3 deg, one standard deviation).
bool IsStepUncertain(const TrackedPose& tracked);

// The points of a frame that are matched against the map, with their beams where rows are beams.
// `cloud` has the frame's features, compensated, in their order.
MapStepPoints PointsForMapStep(const KeyframeCloud& cloud, const PreprocessedFrame& frame,
                               const LidarModel& lidar, double voxel_m);

class FrameTracker {
 public:
  FrameTracker(const SensorSetup& setup, Deskew deskew, const SlamOptions& options);

  // Follows a hypothesis of the pose of `frame`. Times are added to `times`.
  TrackedPose Follow(const PreprocessedFrame& frame, const PoseHypothesis& hypothesis,
                     const TrackingReference& reference, const Executor& executor,
                     StageTimes* times);

  // See VisualLidarOdometry.
  std::optional<RoadMotion> MeasureRoad(const PreprocessedFrame& frame,
                                        const RoadGuess& guess) const {
    return odometry_.MeasureRoad(frame, guess);
  }
  // By odometry alone; the frame's features are those of the whole scan.
  MotionEstimate EstimateOdometry(const PreprocessedFrame& frame, const MotionPrediction& motion,
                                  const Executor& executor);

  // The frame's features, compensated, become what the next frame's odometry is matched against.
  void Advance(const PreprocessedFrame& frame, const KeyframeCloud& cloud);

  // From the next frame on.
  void SetCalibration(const Calibration& calibration) {
    setup_.calibration = calibration;
    odometry_.SetCalibration(calibration);
  }

  // F_ls and F_lf moved to the frame's stamp; unchanged if scans are compensated already.
  KeyframeCloud Compensate(const PreprocessedFrame& frame, const Rigid3d& T_prev_cur,
                           double duration_s) const;
  // What a keyframe keeps of the tracked frame: not what stands where the map knows that nothing
  // stood, for it came there, and will leave.
  KeyframeCloud WithoutNewClusters(const PreprocessedFrame& frame,
                                   const TrackedPose& tracked) const;
  // Scans come compensated: nothing has to be done.
  bool is_compensated() const { return deskew_ == Deskew::kNone; }

 private:
  // Whether the motion is estimated scan to scan before the map step; what is predicted will do
  // where odometry is switched off, a velocity is known, and the map step follows.
  bool NeedsOdometry(const PoseHypothesis& hypothesis, const TrackingReference& reference) const;
  void EstimateMotion(const PreprocessedFrame& frame, const PoseHypothesis& hypothesis,
                      const TrackingReference& reference, const Executor& executor,
                      TrackedPose* tracked);
  void RefineAgainstMap(const PreprocessedFrame& frame, const Rigid3d& T_odom_prior,
                        const TrackingReference& reference, const Executor& executor,
                        TrackedPose* tracked) const;

  SensorSetup setup_;
  Deskew deskew_;
  SlamOptions options_;
  VisualLidarOdometry odometry_;
};

}  // namespace tvl
