// Finds the pose of each frame, and says whether it is to be believed.
//
// Constant velocity is followed first. Where there is doubt (no velocity yet, an irregular stamp, a
// gap, a repeated scan, a frame before that was not tracked, a scan that does not lie on the map as
// usual), other motions are followed beside it, and the one whose scan lies best on the map wins.
// Where none does, the vehicle is lost: the pose is held forward, its covariance grows, and every
// scan is tried against the surroundings of the last known pose until one fits.
#pragma once

#include <optional>
#include <string>

#include "tvl/slam/frame_clock.h"
#include "tvl/slam/frame_tracker.h"
#include "tvl/slam/health.h"
#include "tvl/slam/motion_model.h"
#include "tvl/slam/pose_search.h"
#include "tvl/slam/traffic_monitor.h"

namespace tvl {

// How a frame's pose came about.
enum class FrameStatus {
  kFirst,      // the world's origin, or the first scan there is
  kTracked,    // measured in all directions
  kDegraded,   // measured, but some direction by prediction alone, or by the camera alone
  kPredicted,  // bridged by constant velocity, in all directions or in one: nothing measured it
  kLost,       // the pose is not known; it is held forward and says nothing
};
const char* ToString(FrameStatus status);
// Whether the pose was measured and is to be believed.
bool IsMeasured(FrameStatus status);

// Where the pose that was taken began.
enum class PoseOrigin {
  kPrediction,   // constant velocity over the periods that the stamps say
  kOtherMotion,  // constant velocity over another number of periods, or none
  kAlignment,    // a coarse alignment with the map, without a guess
  kNone,         // no pose was found
};
const char* ToString(PoseOrigin origin);

// The stretch before a pose that was found again: its frames are to be moved so that they lead from
// the last known pose to this one.
struct Bridge {
  Rigid3d T_odom_known;  // of the last frame that was measured
  int periods = 1;       // from there to this frame
};

struct FoundPose {
  TrackedPose tracked;
  FrameStatus status = FrameStatus::kFirst;
  PoseOrigin origin = PoseOrigin::kPrediction;
  int hypotheses = 1;         // followed
  double usual_misfit = 0.0;  // what MapFit::mean was compared with
  // Lost, but one hypothesis lies clearly better than all others: the next frame begins there. It
  // is believed, and written to the map, only when a later scan lies on the map as usual.
  bool is_provisional = false;
  // Measured, but along some direction the vehicle may have moved by more than a claim allows:
  // nothing but prediction has held it for too long, or what moves around may carry it along.
  bool is_uncertain = false;
  // What the step may be off by beyond its covariance, x and y, m^2: a slip that it makes up for,
  // or things that move and alone bear it out.
  Eigen::Matrix2d beyond_covariance_m2 = Eigen::Matrix2d::Zero();
  std::optional<Bridge> bridge;
  // The first motion of raw scans also compensates the scan before it: its features, anew.
  std::optional<KeyframeCloud> previous_cloud;
};

// What the finder is told of a frame besides its data.
struct FrameContext {
  FrameInterval interval;
  bool is_doubtful = false;  // something about the input is wrong, e.g. a scan was repeated
};

class PoseFinder {
 public:
  PoseFinder(const SensorSetup& setup, Deskew deskew, const SlamOptions& options);

  // Of a frame after others without data: the time since the last one that had any.
  FrameContext SinceLastData(FrameContext context) const;

  // What is expected, before the frame is preprocessed.
  MotionPrediction Predict(const FrameInterval& interval) const {
    return motion_.Predict(interval.periods, interval.period_s);
  }

  // Where the traffic around carries the estimate with it: takes out of the frame what may be
  // traffic. Called once a frame, before Find. Returns how many tracks were taken out.
  int RemoveTraffic(const FrameContext& context, PreprocessedFrame* frame,
                    const Executor& executor);

  // The pose of the next frame against `map`, in the odometry frame.
  FoundPose Find(const PreprocessedFrame& frame, const FrameContext& context, const LocalMap& map,
                 const LandmarkMap& landmarks, const Executor& executor, StageTimes* times);

  // The last Advance noticed that the traffic had carried the poses away: the next one makes up for
  // it, and landmarks placed meanwhile are wrong.
  bool was_carried_away() const { return was_carried_away_; }

  // The frame whose pose was found is what the next one is matched against.
  void Advance(PreprocessedFrame frame, const FoundPose& found, const FrameContext& context);

  // The map begins anew at the last frame, where it was held forward to.
  void Restart();

  // From the next frame on.
  void SetCalibration(const Calibration& calibration) {
    setup_.calibration = calibration;
    tracker_.SetCalibration(calibration);
  }

  // How far the vehicle may be from its last known pose, m: at its last speed, and speeding up.
  double MayHaveTravelled_m() const;

  // What a keyframe keeps of the frame. Where so much came that the pose was nearly not believed,
  // what came is left out.
  KeyframeCloud CloudForMap(const PreprocessedFrame& frame, const FoundPose& found) const {
    const bool has_many_new =
        found.tracked.fit.mean - found.usual_misfit > options_.health.lost_rise;
    return has_many_new ? tracker_.WithoutNewClusters(frame, found.tracked) : found.tracked.cloud;
  }

  const PreprocessedFrame& last_frame() const { return last_; }
  const MotionModel& motion() const { return motion_; }

 private:
  struct Search;
  // The motion over the road, where it is one that the vehicle can have made.
  std::optional<RoadMotion> MeasureRoad(const PreprocessedFrame& frame, const Rigid3d& T_prev_cur,
                                        const MotionPrediction& predicted) const;
  // Where traffic was taken out, the motion over the road is what is expected.
  MotionPrediction Expect(const FrameInterval& interval) const;
  // x and y of a motion as the road has them.
  static MotionPrediction OverRoad(MotionPrediction motion, const RoadMotion& road);
  // Where the estimate is found to have been carried away: by how much, and the true motion.
  struct Slip {
    Rigid3d T_slip;
    Rigid3d T_prev_cur;
  };
  // Lidar alone, among moving things: what stands beside the corridor tells whether the pose is
  // carried away; where it does not tell, the pose is uncertain.
  void CompareWithSurroundings(const PreprocessedFrame& frame, const FrameContext& context,
                               const TrackingReference& reference, const Executor& executor,
                               StageTimes* times, FoundPose* found);
  // The motion by the frame without traffic, if that tells.
  std::optional<StandingMotion> MatchSurroundings(const PreprocessedFrame& frame,
                                                  const MotionPrediction& expected,
                                                  const TrackingReference& reference,
                                                  const Executor& executor, StageTimes* times);
  // Compares the estimate with the motion over the road, or against the surroundings.
  std::optional<Slip> WatchTraffic(const PreprocessedFrame& frame, const FoundPose& found,
                                   const FrameContext& context);
  FoundPose First(const PreprocessedFrame& frame, const FrameContext& context) const;
  static bool IsWithoutData(const PreprocessedFrame& frame);
  // A frame without data: where the vehicle would have come to. The next one with data continues
  // the last one that had any, as if there had been none between.
  FoundPose Skip(const PreprocessedFrame& frame, const FrameContext& context) const;
  FoundPose FindStart(const PreprocessedFrame& frame, const FrameContext& context,
                      const LandmarkMap& landmarks, const Executor& executor, StageTimes* times);
  TrackedPose FollowStart(const PreprocessedFrame& frame, MotionPrediction start,
                          const LandmarkMap& landmarks, const Executor& executor, StageTimes* times,
                          KeyframeCloud* previous_cloud);
  // Where the road contradicts the first motion, it is what is followed.
  void FollowRoad(const PreprocessedFrame& frame, const LandmarkMap& landmarks,
                  const Executor& executor, StageTimes* times, FoundPose* best);
  void TryMotions(const PreprocessedFrame& frame, const FrameContext& context, Search* search);
  void TryAlignments(const PreprocessedFrame& frame, const FrameContext& context, Search* search);
  // Where alignments are searched: while lost, in turn about the last known pose, for the vehicle
  // may have stopped there, and about where it would have gone on to.
  Rigid3d SearchCentre(const MotionPrediction& predicted) const;
  double SearchYaw_rad() const;  // half the window
  // Of coarse alignments, the first two and those with the most evidence as they are.
  std::vector<Rigid3d> BestLying(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                                 const LocalMap& map,
                                 const std::vector<Rigid3d>& T_odom_lidar) const;
  // Whether the best hypothesis is where it was expected, by the road if that is known, and traffic
  // hides what would tell: how the rest of the scan lies on the map says nothing then.
  bool IsAmongTraffic(const FrameInterval& interval, const Search& search) const;
  Health Judge(const FrameInterval& interval, const Search& search) const;
  // Whether the best hypothesis has clearly more evidence than all others that ended elsewhere.
  bool IsClearWinner(const Search& search) const;
  // ... and is where the provisional pose before leads to.
  bool IsConfirmed(const Search& search) const;
  FrameStatus StatusOf(const PreprocessedFrame& frame, const TrackedPose& tracked,
                       Health health) const;
  TrackedPose HeldForward(const PreprocessedFrame& frame, const MotionPrediction& predicted) const;

  SensorSetup setup_;
  SlamOptions options_;
  FrameTracker tracker_;
  MotionModel motion_;
  MotionModel before_restart_;  // what was known when the map last began anew
  HealthMonitor health_;
  TrafficMonitor traffic_;
  // Where traffic was taken out of the frame: what it was before, and the motion by all of it.
  struct Whole {
    LaserFeatures features;
    FeatureTracks tracks;
    VisualDepths depths;
    MotionEstimate odometry;
  };
  std::optional<Whole> whole_;
  std::optional<RoadMotion> road_;              // there, if it is known
  std::optional<StandingMotion> surroundings_;  // of the last frame, where it was asked for
  int moving_things_frames_ = 0;                // for so many more, things move about the vehicle
  bool was_carried_away_ = false;
  Eigen::Vector2d slip_m_ = Eigen::Vector2d::Zero();  // then, by how much
  bool has_first_ = false;                            // a scan has been seen
  bool was_measured_ = false;                         // the last frame's pose
  bool is_provisional_ = false;                       // FoundPose::is_provisional of the last frame
  bool is_settled_ = false;                           // it was where constant velocity had it
  int frames_ = 0;
  int periods_unknown_ = 0;  // since the last known pose
  int periods_skipped_ = 0;  // from the last frame with data to the last one, if that had none
  Rigid3d T_odom_prev_, T_odom_known_;
  Matrix6d covariance_unknown_ = Matrix6d::Zero();  // of the way since the last known pose
  PreprocessedFrame last_;
};

}  // namespace tvl
