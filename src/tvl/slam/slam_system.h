// The whole system, synchronous and deterministic: one frame in, one pose out. Reads as the block
// diagram of the paper's Fig. 1.
#pragma once

#include <string>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/map/keyframe.h"
#include "tvl/map/map_cloud.h"
#include "tvl/map/trajectory.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/local_map.h"
#include "tvl/odometry/visual_lidar_odometry.h"
#include "tvl/registration/beam_calibration.h"
#include "tvl/sensor/dataset.h"
#include "tvl/slam/preprocessor.h"
#include "tvl/slam/slam_options.h"
#include "tvl/slam/stage_times.h"

namespace tvl {

// How a frame's pose came about.
enum class FrameStatus {
  kFirst,      // the world's origin
  kTracked,    // odometry and, where due, the map step
  kPredicted,  // nothing usable in the frame: bridged by constant velocity
};
const char* ToString(FrameStatus status);

struct FrameResult {
  FrameId id = 0;
  Timestamp stamp;
  Rigid3d T_world_lidar;
  FrameStatus status = FrameStatus::kFirst;
  // Of T_{k-1,k} in the body frame of k, right perturbation, [rotation, translation].
  Matrix6d step_covariance = Matrix6d::Zero();
  MotionEstimate odometry;   // T_ref_body = T_{k-1,k}
  ScanToMapResult map_step;  // status kFirst where it did not run
  bool is_keyframe = false;
  TrackingStatus tracking = TrackingStatus::kNoImage;
  int tracks = 0, tracks_with_depth = 0;
  std::vector<FrameFault> faults;
  StageTimes times;
};

class SlamSystem {
 public:
  // `deskew` must be decided. Throws InputError for unusable options.
  SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options);

  // Frames in order of time. Never throws for what is wrong with a frame's data.
  FrameResult ProcessFrame(const SensorFrame& frame, const Executor& executor);

  // As given, with the extrinsics that fit the points as the system uses them.
  const SensorSetup& setup() const { return setup_; }
  // What the beams were found to be off by.
  const BeamOffsets& beam_offsets() const { return beams_.offsets(); }
  const Trajectory& trajectory() const { return trajectory_; }
  const Map& map() const { return map_; }
  // The preprocessed data of the last frame, for pictures.
  const PreprocessedFrame& last_frame() const { return last_; }
  // F_lf, F_ls of the last frame compensated to its stamp.
  const KeyframeCloud& last_cloud() const { return last_cloud_; }
  // Motion the last frame's scan was compensated with.
  const PredictedMotion& last_motion() const { return motion_; }

 private:
  PredictedMotion Predict(const SensorFrame& frame) const;
  MotionEstimate EstimateMotion(const PreprocessedFrame& frame, const PredictedMotion& predicted,
                                const Executor& executor);
  KeyframeCloud Compensate(const PreprocessedFrame& frame, const PredictedMotion& motion) const;
  // Compensates the last frame's features anew, for the odometry and, as first keyframe, the map.
  void CompensateLastAgain(const PredictedMotion& motion, const Executor& executor);
  void RefineAgainstMap(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                        const Rigid3d& T_world_guess, const Executor& executor,
                        FrameResult* result);
  void CalibrateBeams(const std::vector<PlaneMatch>& matches, const MapStepPoints& points,
                      const std::vector<LaserFeature>& features, const Rigid3d& T_world_lidar);
  void UpdateMap(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                 const Executor& executor, FrameResult* result);
  void AddKeyframe(const FrameResult& result, const KeyframeCloud& cloud, const Executor& executor);

  SensorSetup setup_;
  Deskew deskew_;
  SlamOptions options_;
  Preprocessor preprocessor_;
  VisualLidarOdometry odometry_;
  LocalMap local_map_;
  LandmarkMap landmarks_;
  BeamCalibration beams_;
  Map map_;
  Trajectory trajectory_;
  PredictedMotion motion_;     // of the last frame, as estimated
  Timestamp clock_;            // of the last frame; runs on where stamps do not advance
  bool has_velocity_ = false;  // motion_ is an estimate
  double path_m_ = 0.0;
  PreprocessedFrame last_;
  KeyframeCloud last_cloud_;
};

// The map in the world frame: all keyframe clouds at their poses, one point a voxel.
MapCloud BuildMapCloud(const Map& map, double voxel_m);

}  // namespace tvl
