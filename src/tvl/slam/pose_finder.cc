#include "tvl/slam/pose_finder.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace tvl {
namespace {

// Of the first motion of a raw recording: scan and motion improve each other in turn.
constexpr int kMaxStartPasses = 10;
constexpr double kStartPrecision_m = 0.002;
// Any first motion is as likely as another. What the odometry finds by itself is still preferred
// where the map, of a single scan, hardly tells: among moving cars it is the better judge.
constexpr double kStartSigmas = 1.5;
// Held forward for longer than this, a pose is lost rather than predicted: half a car's length.
constexpr double kLostSigma_m = 2.0;
// Covariance of a pose from a coarse alignment: a grid cell and a step of the yaw.
constexpr double kAlignedSigma_m = 0.5, kAlignedSigma_rad = 0.05;
// An alignment is off by up to a cell and a step of the yaw at 20 m.
constexpr double kAlignedReach_m = 1.0;
// Beyond this, a hypothesis ended elsewhere: no two poses this far apart fit by the same surfaces.
constexpr double kElsewhere_m = 0.5;
// Where the stamps are in doubt, so is which motion is the most probable.
constexpr double kDoubtfulStampSigmas = 1.0;
// A provisional pose lies better than all others by so many standard errors; it is confirmed later.
constexpr double kClearSigmas = 1.5;
// A worse fit of fewer points than this share of the best one's is no rival.
constexpr double kRivalShare = 0.75;
// Two hypotheses that end this close are one.
constexpr double kSame_m = 0.05, kSame_rad = 0.005;
// Share of the strongest direction's information below which the camera does not hold a direction
// that the lidar does not hold either.
constexpr double kHeldByCamera = 0.0005;

Matrix6d AlignedCovariance() {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(kAlignedSigma_rad * kAlignedSigma_rad),
      Eigen::Vector3d::Constant(kAlignedSigma_m * kAlignedSigma_m);
  return variance.asDiagonal();
}

std::vector<Eigen::Vector3f> AllPoints(const KeyframeCloud& cloud) {
  std::vector<Eigen::Vector3f> points = cloud.planes.points;
  points.insert(points.end(), cloud.edges.points.begin(), cloud.edges.points.end());
  return points;
}

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d difference = a.Inverse() * b;
  return difference.t().norm() < kSame_m && difference.RotationAngle() < kSame_rad;
}

bool HoldsAllDirections(const MotionEstimate& estimate) {
  return std::all_of(estimate.weak.begin(), estimate.weak.end(), [](const WeakDirection& weak) {
    return weak.camera_strength > kHeldByCamera;
  });
}

const MotionEstimate& FinalEstimate(const TrackedPose& tracked) {
  const MotionEstimate& by_map = tracked.map_step.estimate;
  const bool has_map_step =
      by_map.status != EstimateStatus::kFirst && by_map.status != EstimateStatus::kPredicted;
  return has_map_step ? by_map : tracked.odometry;
}

// Whether the step's error along a direction that nothing but prediction holds may exceed what a
// claim to be measured allows (a third of 0.3 m and 3 deg, one standard deviation).
bool IsStepUncertain(const TrackedPose& tracked) {
  constexpr double kMost_m = 0.1, kMost_rad = 0.0175;
  const Matrix6d& covariance = tracked.step_covariance;
  const std::vector<WeakDirection>& weak = FinalEstimate(tracked).weak;
  return std::any_of(weak.begin(), weak.end(), [&](const WeakDirection& direction) {
    const int first = direction.is_rotation ? 0 : 3;
    const Eigen::Vector3d& axis = direction.axis_lidar;
    const double sigma = std::sqrt(axis.dot(covariance.block<3, 3>(first, first) * axis));
    return sigma > (direction.is_rotation ? kMost_rad : kMost_m);
  });
}

}  // namespace

const char* ToString(FrameStatus status) {
  switch (status) {
    case FrameStatus::kFirst:
      return "first";
    case FrameStatus::kTracked:
      return "tracked";
    case FrameStatus::kDegraded:
      return "degraded";
    case FrameStatus::kPredicted:
      return "predicted";
    case FrameStatus::kLost:
      return "lost";
  }
  return "unknown";
}

bool IsMeasured(FrameStatus status) {
  return status == FrameStatus::kFirst || status == FrameStatus::kTracked ||
         status == FrameStatus::kDegraded;
}

const char* ToString(PoseOrigin origin) {
  switch (origin) {
    case PoseOrigin::kPrediction:
      return "prediction";
    case PoseOrigin::kOtherMotion:
      return "other_motion";
    case PoseOrigin::kAlignment:
      return "alignment";
    case PoseOrigin::kNone:
      return "none";
  }
  return "unknown";
}

// The hypotheses of one frame: what they are followed against, and the best so far.
struct PoseFinder::Search {
  TrackingReference reference;
  const Executor& executor;
  StageTimes* times;
  Rigid3d T_odom_expected;
  // Whether the vehicle can have come to this pose.
  std::function<bool(const Rigid3d&)> is_reachable;
  // By how much a hypothesis must lie better than a more probable one.
  double min_better_sigmas;
  FoundPose best;
  // Of all hypotheses followed: where they ended, and how that lies on the map.
  std::vector<std::pair<Rigid3d, MapFit>> ends;

  // Follows a hypothesis; takes it if it is clearly better than the best so far.
  void Try(FrameTracker* tracker, const HealthMonitor& health, const PreprocessedFrame& frame,
           const PoseHypothesis& hypothesis, PoseOrigin origin) {
    TrackedPose tracked = tracker->Follow(frame, hypothesis, reference, executor, times);
    ++best.hypotheses;
    const bool is_new = std::none_of(ends.begin(), ends.end(), [&](const auto& end) {
      return IsSame(end.first, tracked.T_odom_lidar);
    });
    ends.emplace_back(tracked.T_odom_lidar, tracked.fit);
    if (!is_new || !is_reachable(tracked.T_odom_lidar)) return;
    if (!health.IsBetter(tracked, best.tracked, min_better_sigmas)) return;
    best.tracked = std::move(tracked);
    best.origin = origin;
  }
};

PoseFinder::PoseFinder(const SensorSetup& setup, Deskew deskew, const SlamOptions& options)
    : setup_(setup),
      options_(options),
      tracker_(setup, deskew, options),
      motion_(options.motion),
      before_restart_(options.motion),
      health_(options.health) {}

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
      AllPoints(here), map, T_odom_prev_, options_.search.start_radius_m * context.interval.periods,
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
  tracker_.Advance(last_, *best.previous_cloud);
  best.hypotheses = static_cast<int>(starts.size());
  if (tracker_.is_compensated()) best.previous_cloud.reset();
  best.status =
      StatusOf(frame, best.tracked, best.tracked.is_measured ? Health::kGood : Health::kBad);
  best.is_uncertain = best.status == FrameStatus::kDegraded && IsStepUncertain(best.tracked);
  return best;
}

void PoseFinder::TryMotions(const PreprocessedFrame& frame, const FrameContext& context,
                            Search* search) {
  std::vector<MotionPrediction> motions = AlternativeMotions(motion_, context.interval);
  for (size_t i = 1; i < motions.size(); ++i) {
    search->Try(&tracker_, health_, frame, PoseHypothesis::Of(motions[i], T_odom_prev_),
                PoseOrigin::kOtherMotion);
  }
}

void PoseFinder::TryAlignments(const PreprocessedFrame& frame, const FrameContext& context,
                               Search* search) {
  const MotionPrediction predicted = Predict(context.interval);
  const KeyframeCloud cloud =
      tracker_.Compensate(frame, predicted.T_prev_cur, predicted.duration_s());
  const double yaw_window_rad =
      periods_unknown_ > 0 ? options_.search.lost_yaw_window_rad : options_.search.yaw_window_rad;
  const std::vector<Rigid3d> aligned = AlignWithoutGuess(
      AllPoints(cloud), search->reference.map, T_odom_known_, options_.search.radius_m,
      yaw_window_rad, options_.search, search->executor);
  const std::vector<Rigid3d> best = BestLying(frame, cloud, search->reference.map, aligned);
  for (const Rigid3d& T_odom : best) {
    PoseHypothesis hypothesis{T_odom, AlignedCovariance(), predicted, false};
    search->Try(&tracker_, health_, frame, hypothesis, PoseOrigin::kAlignment);
  }
}

std::vector<Rigid3d> PoseFinder::BestLying(const PreprocessedFrame& frame,
                                           const KeyframeCloud& cloud, const LocalMap& map,
                                           const std::vector<Rigid3d>& T_odom_lidar) const {
  MapFitOptions coarse = options_.mapping.fit;
  coarse.max_distance_m = kAlignedReach_m;
  const std::vector<FitSample> sample = SampleForFit(frame.features.less_flat, coarse);
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < T_odom_lidar.size(); ++i) {
    const MapFit fit = FitToMap(cloud.planes.points, sample, map, T_odom_lidar[i], coarse);
    order.emplace_back(fit.mean, i);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), static_cast<size_t>(options_.search.max_followed)));
  std::vector<Rigid3d> best;
  for (const auto& [misfit, i] : order) best.push_back(T_odom_lidar[i]);
  return best;
}

TrackedPose PoseFinder::HeldForward(const PreprocessedFrame& frame,
                                    const MotionPrediction& predicted) const {
  TrackedPose held;
  held.start = predicted;
  held.odometry.T_ref_body = predicted.T_prev_cur;
  held.odometry.covariance = predicted.covariance;
  held.odometry.status = EstimateStatus::kPredicted;
  held.T_odom_lidar = T_odom_prev_ * predicted.T_prev_cur;
  held.step_covariance = predicted.covariance;
  held.cloud = tracker_.Compensate(frame, predicted.T_prev_cur, predicted.duration_s());
  return held;
}

// After a leap or while lost, a pose is believed if its scan lies on the map as usual, or if two
// frames in a row lie clearly better there than anywhere else.
Health PoseFinder::Judge(const Search& search) const {
  const bool was_lost = !was_measured_ && !is_provisional_;
  const bool is_unfounded = search.best.tracked.fit.judged < options_.health.min_judged;
  if (is_provisional_ && is_unfounded) return Health::kBad;
  const Health health = health_.Judge(search.best.tracked, search.T_odom_expected, was_lost);
  const bool needs_confirmation = is_provisional_ && health == Health::kSuspicious;
  return needs_confirmation && !IsClearWinner(search) ? Health::kBad : health;
}

bool PoseFinder::IsClearWinner(const Search& search) const {
  const TrackedPose& best = search.best.tracked;
  if (best.fit.judged < options_.health.min_judged || search.ends.size() < 3) return false;
  return std::all_of(search.ends.begin(), search.ends.end(), [&](const auto& end) {
    if ((best.T_odom_lidar.t() - end.first.t()).norm() < kElsewhere_m) return true;
    const bool is_thin = end.second.judged < kRivalShare * best.fit.judged;
    if (is_thin && end.second.mean > best.fit.mean) return true;
    const FitComparison comparison = Compare(best.fit, end.second);
    return comparison.common < options_.health.min_judged ||
           comparison.better > kClearSigmas * comparison.standard_error;
  });
}

FrameStatus PoseFinder::StatusOf(const PreprocessedFrame& frame, const TrackedPose& tracked,
                                 Health health) const {
  if (health == Health::kBad) {
    const bool has_data = frame.has_scan || tracked.is_measured;
    const Matrix6d covariance = covariance_unknown_ + tracked.start.covariance;
    const double sigma_m = std::sqrt(covariance.block<3, 3>(3, 3).trace());
    return has_data || sigma_m > kLostSigma_m ? FrameStatus::kLost : FrameStatus::kPredicted;
  }
  return frame.has_scan && HoldsAllDirections(FinalEstimate(tracked)) ? FrameStatus::kTracked
                                                                      : FrameStatus::kDegraded;
}

FoundPose PoseFinder::Find(const PreprocessedFrame& frame, const FrameContext& context,
                           const LocalMap& map, const LandmarkMap& landmarks,
                           const Executor& executor, StageTimes* times) {
  if (!has_first_) return First(frame, context);
  if (!motion_.known() && was_measured_ && last_.has_scan) {
    return FindStart(frame, context, landmarks, executor, times);
  }
  const MotionPrediction predicted = Predict(context.interval);
  const bool is_due = frames_ % options_.mapping.interval == 0;
  // While lost the vehicle may have been moved by other means.
  const auto is_reachable = [&](const Rigid3d& T_odom_lidar) {
    return !was_measured_ ||
           IsReachable(motion_, context.interval.period_s, T_odom_prev_.Inverse() * T_odom_lidar);
  };
  Search search{{T_odom_prev_, map, landmarks, is_due},
                executor,
                times,
                T_odom_prev_ * predicted.T_prev_cur,
                is_reachable,
                options_.health.min_better_sigmas,
                {},
                {}};
  if (context.interval.verdict != StampVerdict::kRegular) {
    search.min_better_sigmas = std::min(search.min_better_sigmas, kDoubtfulStampSigmas);
  }
  PoseHypothesis hypothesis = PoseHypothesis::Of(predicted, T_odom_prev_);
  hypothesis.use_odometry = was_measured_ || is_provisional_;
  search.best.tracked = tracker_.Follow(frame, hypothesis, search.reference, executor, times);
  search.ends.emplace_back(search.best.tracked.T_odom_lidar, search.best.tracked.fit);

  Health health = Judge(search);
  const bool is_doubtful =
      context.is_doubtful || !is_settled_ || context.interval.verdict != StampVerdict::kRegular;
  if (frame.has_scan && (is_doubtful || health != Health::kGood)) {
    if (was_measured_ || is_provisional_) TryMotions(frame, context, &search);
    health = Judge(search);
    if (!was_measured_ || health != Health::kGood) TryAlignments(frame, context, &search);
    health = Judge(search);
  }
  const bool is_clear = health == Health::kBad && IsClearWinner(search);
  FoundPose found = std::move(search.best);
  found.usual_misfit = health_.usual_misfit();
  found.status = StatusOf(frame, found.tracked, health);
  found.is_uncertain = found.status == FrameStatus::kDegraded && IsStepUncertain(found.tracked);
  if (!IsMeasured(found.status) && is_clear) {
    found.is_provisional = true;
  } else if (!IsMeasured(found.status)) {
    const MapFit fit = found.tracked.fit;
    found.tracked = HeldForward(frame, predicted);
    found.tracked.fit = fit;
    found.origin = PoseOrigin::kNone;
  } else if (periods_unknown_ > 0) {
    found.bridge = Bridge{T_odom_known_, periods_unknown_ + context.interval.periods};
  }
  return found;
}

void PoseFinder::Advance(PreprocessedFrame frame, const FoundPose& found,
                         const FrameContext& context) {
  const TrackedPose& tracked = found.tracked;
  tracker_.Advance(frame, tracked.cloud);
  const bool is_measured = IsMeasured(found.status);
  const bool is_settled =
      is_measured && !found.bridge && motion_.known() && found.origin == PoseOrigin::kPrediction;
  if (has_first_ && found.status != FrameStatus::kFirst) {
    const bool tells_velocity =
        !found.bridge && (found.origin != PoseOrigin::kAlignment || !motion_.known());
    if (is_measured && tells_velocity) {
      motion_.Update(tracked.Motion(T_odom_prev_), tracked.step_covariance, tracked.start.periods);
    } else {
      motion_.Coast(context.interval.periods);
    }
  }
  if (is_measured) {
    health_.Learn(tracked);
    T_odom_known_ = tracked.T_odom_lidar;
    periods_unknown_ = 0;
    covariance_unknown_.setZero();
  } else {
    periods_unknown_ += context.interval.periods;
    covariance_unknown_ += tracked.step_covariance;
  }
  has_first_ = has_first_ || frame.has_scan;
  was_measured_ = is_measured;
  is_settled_ = is_settled;
  is_provisional_ = found.is_provisional;
  T_odom_prev_ = tracked.T_odom_lidar;
  last_ = std::move(frame);
  ++frames_;
}

double PoseFinder::MayHaveTravelled_m() const {
  constexpr double kSpeedingUp_m_s2 = 1.5;  // a car in town
  const double time_s = periods_unknown_ * setup_.lidar.sweep_s;
  return periods_unknown_ * motion_.T_period().t().norm() +
         0.5 * kSpeedingUp_m_s2 * time_s * time_s;
}

void PoseFinder::Restart() {
  before_restart_ = motion_;
  motion_.Forget();
  is_provisional_ = false;
  was_measured_ = true;
  periods_unknown_ = 0;
  covariance_unknown_.setZero();
  T_odom_known_ = T_odom_prev_;
}

}  // namespace tvl
