// The whole system, deterministic: one frame in, one pose out; loops are searched beside it. Reads
// as the block diagram of the paper's Fig. 1.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/map/map.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/lidar_only_path.h"
#include "tvl/mapping/local_map.h"
#include "tvl/registration/beam_calibration.h"
#include "tvl/registration/extrinsic_calibration.h"
#include "tvl/sensor/dataset.h"
#include "tvl/slam/calibration_check.h"
#include "tvl/slam/loop_closer.h"
#include "tvl/slam/loop_thread.h"
#include "tvl/slam/pose_finder.h"
#include "tvl/slam/pose_uncertainty.h"
#include "tvl/slam/preprocessor.h"
#include "tvl/slam/repetition.h"
#include "tvl/slam/slam_options.h"
#include "tvl/slam/stage_times.h"

namespace tvl {

// Asked during the second look at all keyframes without a loop, at the end of the data: false ends
// it. From any thread.
using GoOn = std::function<bool()>;

struct FrameResult {
  FrameId id = 0;
  Timestamp stamp;
  // In the odometry frame, which never jumps; and in the world, as known when the frame was
  // processed (loops found later correct it, see SlamSystem::trajectory).
  Rigid3d T_odom_lidar;
  Rigid3d T_world_lidar;
  FrameStatus status = FrameStatus::kFirst;
  // Of T_{k-1,k} in the body frame of k (of the whole stretch since the last frame with data, where
  // frames without any lie between), right perturbation, [rotation, translation].
  Matrix6d step_covariance = Matrix6d::Zero();
  // Of T_odom_lidar against that of the first frame, in the same form (pose_uncertainty.h). Steps
  // share errors: their covariances do not add up to it.
  Matrix6d pose_covariance = Matrix6d::Zero();
  // Its parts: of the pose against the map, and what the step adds to the map's own error.
  Matrix6d noise_covariance = Matrix6d::Zero(), walk_covariance = Matrix6d::Zero();
  MotionEstimate odometry;   // T_ref_body = T_{k-1,k}
  ScanToMapResult map_step;  // in the odometry frame; status kFirst where it did not run
  // How well the scan lies on the map, 0 (best) to 1 (MapFit::mean), over how many points, and what
  // was usual before.
  double misfit = 0.0, usual_misfit = 0.0;
  double misfit_points = 0.0;
  PoseOrigin origin = PoseOrigin::kPrediction;
  int hypotheses = 1;  // of the motion that were followed
  bool is_keyframe = false;
  // Lost for too long: from here on poses are right against this frame, whose own place is a guess.
  bool map_begins_anew = false;
  TrackingStatus tracking = TrackingStatus::kNoImage;
  // Tracks used, with the lidar's depth, and left out because what they lie on moves.
  int tracks = 0, tracks_with_depth = 0, tracks_moving = 0;
  std::vector<FrameFault> faults;
  StageTimes times;
};

// What became of a frame on its way, for pictures.
struct FrameTrace {
  PreprocessedFrame frame;
  PredictedMotion motion;  // that the scan was compensated with
};

class SlamSystem {
 public:
  // `deskew` must be decided. With `in_background` loops are searched beside the odometry, in a
  // thread of their own; results are the same. Throws InputError for unusable options.
  SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options,
             bool in_background = false);

  // Frames in order of time. Never throws for what is wrong with a frame's data: what no stage can
  // work with is left out and is a fault of the frame. A `trace` is filled where one is given, and
  // left as it is for a frame that repeats the one before.
  FrameResult ProcessFrame(const SensorFrame& frame, const Executor& executor,
                           FrameTrace* trace = nullptr);

  // After the last frame: waits for the loop search, which looks once more at all keyframes (it can
  // take half a minute; none at all if `go_on` says no from the start), and applies everything
  // found.
  void Finish(const GoOn& go_on = [] { return true; });

  // Why the loop search ended before its time; empty: it did not. Poses are those known until then.
  const std::string& loop_fault() const { return loop_fault_; }
  // It ended because the program is wrong, not because a file could not be read.
  bool loop_search_broke() const { return loop_search_broke_; }
  // After Finish(): every proposal, what it was judged on, and the graph. Empty without loops.
  const LoopReport& loops() const;

  // What the camera's extrinsics were found to be off by.
  ExtrinsicEstimate extrinsics() const { return extrinsics_.estimate(); }
  // As given, with the extrinsics as they are known by now.
  const SensorSetup& setup() const { return setup_; }
  // What the beams were found to be off by.
  const BeamOffsets& beam_offsets() const { return beams_.offsets(); }
  // Of all frames, with every correction known by now.
  Trajectory trajectory() const { return WorldTrajectory(path_, map_.keyframes); }
  const OdometryPath& odometry_path() const { return path_; }
  // What the next frame is registered against, in the odometry frame.
  const LocalMap& local_map() const { return local_map_; }
  const Map& map() const { return map_; }

 private:
  // The input without what was delivered before, and with what is said of its time; faults are
  // added to it.
  SensorFrame WithoutRepetitions(SensorFrame frame, FrameContext* context);
  FrameResult RepeatLastPose(FrameResult result);
  // By the newest keyframe.
  Rigid3d InWorld(const Rigid3d& T_odom_lidar) const;
  // For the visual search alone: empty without it.
  ImageFeatures DescribeImage(const SensorFrame& frame,
                              const PreprocessedFrame& preprocessed) const;
  // What a frame's result says of its data and of the pose found.
  void Describe(const PreprocessedFrame& frame, const FoundPose& found, FrameResult* result) const;
  void CalibrateBeams(const FoundPose& found, const PreprocessedFrame& frame);
  // `all_tracks`: those on moving things, too.
  void CalibrateExtrinsics(const PreprocessedFrame& frame, const FeatureTracks& all_tracks,
                           const FoundPose& found, const Executor& executor, FrameResult* result);
  // With poses that the camera has no part in; `T_image` is the motion from the scan's instant to
  // the image's. True if the extrinsics changed.
  bool CheckExtrinsics(const PreprocessedFrame& frame, const FoundPose& found,
                       const Rigid3d& T_image, const Executor& executor);
  // What was seen before the pose was lost, or moved, does not continue.
  void ForgetViews();
  // As far as they are known by now, from the next frame on.
  void UseExtrinsics();
  // Of an image that is late, in a frame with that motion.
  // Of the frame's image after its scan: as recorded, and what was found beside that.
  double ImageDelay_s() const { return image_delay_s_ + extrinsics_.delay_s(); }
  void UseDelay(const PredictedMotion& motion);
  // The scan before this one was compensated anew: replaces it where it is a keyframe.
  void ReplaceLastCloud(KeyframeCloud cloud, const Executor& executor);
  // Path and covariance since the last keyframe; the stretch before a pose that was found again.
  void Advance(const FoundPose& found, FrameResult* result);
  // What a step adds to the uncertainty of the poses, and what of it the result says.
  void AddUncertainty(const FoundPose& found, const Rigid3d& T_prev_cur, FrameResult* result);
  void LayBridge(const Bridge& bridge, const Rigid3d& T_odom_lidar);
  // The frames since the last known pose.
  void MoveBetween(const Rigid3d& T_odom_known, const Rigid3d& T_odom_lidar);
  bool IsDueKeyframe(const PreprocessedFrame& frame, const FrameResult& result) const;
  // Lost for too long: the map begins anew at this frame.
  void Restart(const FrameResult& result, const Executor& executor);
  void AddKeyframe(const FrameResult& result, KeyframePayload payload, const Executor& executor);
  // Hands the newest keyframe to the loop search and applies what is due.
  void CloseLoops(const Executor& executor);
  void Apply(const LoopUpdate& update);
  // The loop search has thrown: only its first fault counts.
  void EndLoopSearch(const std::exception& error);
  // Applies the oldest result that is waiting; what the loop search found wrong ends it.
  std::vector<int> ApplyNext();
  // Fetches keyframes of earlier passes into the local map.
  void Connect(const std::vector<int>& keyframes, const Executor& executor);

  SensorSetup setup_;
  SlamOptions options_;
  Preprocessor preprocessor_;
  PoseFinder finder_;
  FrameClock clock_;
  RepetitionCheck repetition_;
  LocalMap local_map_;
  LandmarkMap landmarks_;
  MovingTracks moving_tracks_;
  BeamCalibration beams_;
  ExtrinsicCalibration extrinsics_;
  LidarOnlyPath lidar_only_;
  CalibrationCheck calibration_check_;
  Map map_;
  OdometryPath path_;
  PredictedMotion last_motion_;  // of the last frame, as estimated
  Timestamp stamp_;              // of the last frame; runs on where stamps do not advance
  FrameStatus last_status_ = FrameStatus::kFirst;
  double image_delay_s_ = 0.0;  // SensorFrame::image_delay_s of the frame
  bool is_delayed_ = false;     // the calibration in use is that of a delayed image
  bool was_repeated_ = false;   // the last frame
  int lost_scans_ = 0;          // in a row
  double path_m_ = 0.0;
  OdometryUncertainty uncertainty_;
  // As of the last pose that is known.
  struct Known {
    size_t path = 0;  // index
    double path_m = 0.0;
    OdometryUncertainty uncertainty;
  } known_;
  KeyframeCloud last_cloud_;
  std::shared_ptr<LoopCloser> loop_closer_;  // shared with the work in the thread
  LoopThread loop_thread_;
  std::string loop_fault_;
  bool loop_search_broke_ = false;
};

}  // namespace tvl
