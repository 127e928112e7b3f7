// The whole system, deterministic: one frame in, one pose out; loops are searched beside it. Reads
// as the block diagram of the paper's Fig. 1.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/map/map.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/local_map.h"
#include "tvl/odometry/visual_lidar_odometry.h"
#include "tvl/registration/beam_calibration.h"
#include "tvl/sensor/dataset.h"
#include "tvl/slam/loop_closer.h"
#include "tvl/slam/loop_thread.h"
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

// At all keyframes without a loop, at the end of the data.
enum class SecondLook { kYes, kNo };

struct FrameResult {
  FrameId id = 0;
  Timestamp stamp;
  // In the odometry frame, which never jumps; and in the world, as known when the frame was
  // processed (loops found later correct it, see SlamSystem::trajectory).
  Rigid3d T_odom_lidar;
  Rigid3d T_world_lidar;
  FrameStatus status = FrameStatus::kFirst;
  // Of T_{k-1,k} in the body frame of k, right perturbation, [rotation, translation].
  Matrix6d step_covariance = Matrix6d::Zero();
  MotionEstimate odometry;   // T_ref_body = T_{k-1,k}
  ScanToMapResult map_step;  // in the odometry frame; status kFirst where it did not run
  bool is_keyframe = false;
  TrackingStatus tracking = TrackingStatus::kNoImage;
  int tracks = 0, tracks_with_depth = 0;
  std::vector<FrameFault> faults;
  StageTimes times;
};

class SlamSystem {
 public:
  // `deskew` must be decided. With `in_background` loops are searched beside the odometry, in a
  // thread of their own; results are the same. Throws InputError for unusable options.
  SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options,
             bool in_background = false);

  // Frames in order of time. Never throws for what is wrong with a frame's data.
  FrameResult ProcessFrame(const SensorFrame& frame, const Executor& executor);

  // After the last frame: waits for the loop search, which looks once more at all keyframes unless
  // told not to (it can take half a minute), and applies everything found.
  void Finish(SecondLook second_look = SecondLook::kYes);

  // Why the loop search ended before its time; empty: it did not. Poses are those known until then.
  const std::string& loop_fault() const { return loop_fault_; }
  // After Finish(): every proposal, what it was judged on, and the graph. Empty without loops.
  const LoopReport& loops() const;

  // As given, with the extrinsics that fit the points as the system uses them.
  const SensorSetup& setup() const { return setup_; }
  // What the beams were found to be off by.
  const BeamOffsets& beam_offsets() const { return beams_.offsets(); }
  // Of all frames, with every correction known by now.
  Trajectory trajectory() const { return WorldTrajectory(path_, map_.keyframes); }
  const OdometryPath& odometry_path() const { return path_; }
  // What the next frame is registered against, in the odometry frame.
  const LocalMap& local_map() const { return local_map_; }
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
                        const Rigid3d& T_odom_guess, const Executor& executor, FrameResult* result);
  void CalibrateBeams(const std::vector<PlaneMatch>& matches, const MapStepPoints& points,
                      const std::vector<LaserFeature>& features, const Rigid3d& T_odom_lidar);
  // The frame's pose is known: where the next one starts from.
  void Advance(const FrameResult& result, const PredictedMotion& motion);
  // Decides whether the frame becomes a keyframe.
  bool UpdateLandmarks(const PreprocessedFrame& frame, const FrameResult& result);
  void AddKeyframe(const FrameResult& result, KeyframePayload payload, const Executor& executor);
  // Hands the newest keyframe to the loop search and applies what is due.
  void CloseLoops(const Executor& executor);
  void Apply(const LoopUpdate& update);
  // Applies the oldest result that is waiting; what the loop search found wrong ends it.
  std::vector<int> ApplyNext();
  // Fetches keyframes of earlier passes into the local map.
  void Connect(const std::vector<int>& keyframes, const Executor& executor);

  SensorSetup setup_;
  Deskew deskew_;
  SlamOptions options_;
  Preprocessor preprocessor_;
  VisualLidarOdometry odometry_;
  LocalMap local_map_;
  LandmarkMap landmarks_;
  BeamCalibration beams_;
  Map map_;
  OdometryPath path_;
  PredictedMotion motion_;     // of the last frame, as estimated
  Timestamp clock_;            // of the last frame; runs on where stamps do not advance
  bool has_velocity_ = false;  // motion_ is an estimate
  double path_m_ = 0.0;
  Matrix6d keyframe_covariance_ = Matrix6d::Zero();  // of the motion since the last keyframe
  PreprocessedFrame last_;
  KeyframeCloud last_cloud_;
  std::shared_ptr<LoopCloser> loop_closer_;  // shared with the work in the thread
  LoopThread loop_thread_;
  std::string loop_fault_;
};

}  // namespace tvl
