// The first motion: nothing is expected of it, and raw scans are not compensated yet.
#include <algorithm>

#include "tvl/slam/pose_finder.h"

namespace tvl {
namespace {

// Of the first motion of a raw recording: scan and motion improve each other in turn.
constexpr int kMaxStartPasses = 10;
constexpr double kStartPrecision_m = 0.002;
// Any first motion is as likely as another. What the odometry finds by itself is still preferred
// where the map, of a single scan, hardly tells: among moving cars it is the better judge.
constexpr double kStartSigmas = 1.5;

}  // namespace

FoundPose PoseFinder::First(const PreprocessedFrame& frame, const FrameContext& context) const {
  FoundPose found;
  found.tracked.start = Predict(context.interval);
  found.tracked.T_odom_lidar = T_odom_prev_;
  found.tracked.cloud = tracker_.Compensate(frame, Rigid3d(), context.interval.period_s);
  found.status = frames_ == 0 || frame.has_scan ? FrameStatus::kFirst : FrameStatus::kPredicted;
  return found;
}

// The scan before was compensated without a known motion. The one found now does it better, which
// makes it better itself: its error falls by half each time.
TrackedPose PoseFinder::FollowStart(const PreprocessedFrame& frame, MotionPrediction start,
                                    const LandmarkMap& landmarks, const Executor& executor,
                                    StageTimes* times, KeyframeCloud* previous_cloud) {
  TrackedPose tracked;
  for (int pass = 0; pass < kMaxStartPasses; ++pass) {
    *previous_cloud = tracker_.Compensate(last_, start.T_prev_cur, start.duration_s());
    tracker_.Advance(last_, *previous_cloud);
    LocalMap map(options_.mapping.local_map);
    map.Add({0, 0.0, T_odom_prev_, std::make_shared<const KeyframeCloud>(*previous_cloud)},
            executor);
    const TrackingReference reference{T_odom_prev_, map, landmarks,
                                      frames_ % options_.mapping.interval == 0};
    tracked =
        tracker_.Follow(frame, PoseHypothesis::Of(start, T_odom_prev_), reference, executor, times);
    const Rigid3d T_prev_cur = tracked.Motion(T_odom_prev_);
    const double change_m = (start.T_prev_cur.t() - T_prev_cur.t()).norm();
    if (!tracked.is_measured || tracker_.is_compensated() || change_m < kStartPrecision_m) break;
    start.T_prev_cur = T_prev_cur;
    start.known = true;
  }
  return tracked;
}

FoundPose PoseFinder::FindStart(const PreprocessedFrame& frame, const FrameContext& context,
                                const LandmarkMap& landmarks, const Executor& executor,
                                StageTimes* times) {
  std::vector<MotionPrediction> starts(2, Predict(context.interval));
  starts[1].known = true;  // standing; the first lets the odometry search
  const KeyframeCloud here = tracker_.Compensate(frame, Rigid3d(), context.interval.period_s);
  const KeyframeCloud before = tracker_.Compensate(last_, Rigid3d(), context.interval.period_s);
  LocalMap map(options_.mapping.local_map);
  map.Add({0, 0.0, T_odom_prev_, std::make_shared<const KeyframeCloud>(before)}, executor);
  const std::vector<Rigid3d> aligned = AlignWithoutGuess(
      AllPoints(here), map, T_odom_prev_,
      std::min(options_.search.radius_m, options_.search.start_radius_m * context.interval.periods),
      options_.search.yaw_window_rad, options_.search, executor);
  for (const Rigid3d& T_odom : BestLying(frame, here, map, aligned)) {
    starts.push_back(starts[1]);
    starts.back().T_prev_cur = T_odom_prev_.Inverse() * T_odom;
  }
  if (!tracker_.is_compensated() && context.interval.periods > 1) {
    // The stamps may be wrong about the time between the first frames, which bends raw scans.
    const size_t stamped = starts.size();
    for (size_t i = 0; i < stamped; ++i) {
      starts.push_back(starts[i]);
      starts.back().periods = 1;
    }
  }
  FoundPose best;
  for (size_t i = 0; i < starts.size(); ++i) {
    KeyframeCloud previous;
    TrackedPose tracked = FollowStart(frame, starts[i], landmarks, executor, times, &previous);
    if (i > 0 && !health_.IsBetter(tracked, best.tracked, kStartSigmas)) continue;
    best.tracked = std::move(tracked);
    best.previous_cloud = std::move(previous);
    best.origin = i < 2 ? PoseOrigin::kPrediction : PoseOrigin::kOtherMotion;
  }
  if (before_restart_.known() && best.tracked.fit.judged < options_.health.min_judged) {
    // Nothing tells the starts apart: the speed before the map began anew is the best guess.
    KeyframeCloud previous;
    best.tracked = FollowStart(
        frame, before_restart_.Predict(context.interval.periods, context.interval.period_s),
        landmarks, executor, times, &previous);
    best.previous_cloud = std::move(previous);
    best.origin = PoseOrigin::kPrediction;
  }
  FollowRoad(frame, landmarks, executor, times, &best);
  tracker_.Advance(last_, *best.previous_cloud);
  best.hypotheses = static_cast<int>(starts.size());
  if (tracker_.is_compensated()) best.previous_cloud.reset();
  best.status =
      StatusOf(frame, best.tracked, best.tracked.is_measured ? Health::kGood : Health::kBad);
  best.is_uncertain = best.status == FrameStatus::kDegraded && IsStepUncertain(best.tracked);
  return best;
}

void PoseFinder::FollowRoad(const PreprocessedFrame& frame, const LandmarkMap& landmarks,
                            const Executor& executor, StageTimes* times, FoundPose* best) {
  const std::optional<RoadMotion> road =
      tracker_.MeasureRoad(frame, {best->tracked.Motion(T_odom_prev_)});
  if (!road || !traffic_.Start(best->tracked.Motion(T_odom_prev_), *road,
                               best->tracked.start.duration_s())) {
    return;
  }
  PreprocessedFrame without = frame;
  traffic_.RemoveTraffic(road, &without);
  MotionPrediction start = OverRoad(best->tracked.start, *road);
  start.known = true;
  KeyframeCloud previous;
  best->tracked = FollowStart(without, start, landmarks, executor, times, &previous);
  best->tracked.map_step_source.clear();  // indices into the features that are left
  best->tracked.cloud =
      tracker_.Compensate(frame, best->tracked.Motion(T_odom_prev_), start.duration_s());
  best->previous_cloud = std::move(previous);
  best->origin = PoseOrigin::kOtherMotion;
}

}  // namespace tvl
