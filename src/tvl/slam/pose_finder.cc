#include "tvl/slam/pose_finder.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace tvl {
namespace {

// Held forward for longer than this, a pose is lost rather than predicted: half a car's length.
constexpr double kLostSigma_m = 2.0;
// Covariance of a pose from a coarse alignment: a grid cell and a step of the yaw.
constexpr double kAlignedSigma_m = 0.5, kAlignedSigma_rad = 0.05;
// An alignment is off by up to a cell and a step of the yaw at 20 m.
constexpr double kAlignedReach_m = 1.0;
// Alignments, best first, that are followed whatever their evidence.
constexpr size_t kFirstAlignments = 2;
// Beyond this, a hypothesis ended elsewhere: no two poses this far apart fit by the same surfaces.
constexpr double kElsewhere_m = 0.5;
// Where the stamps are in doubt, so is which motion is the most probable.
constexpr double kDoubtfulStampSigmas = 1.0;
// A pose found while lost lies on the map by so many points more than off it, and by so many
// standard errors, which a wrong one has by chance once in a thousand.
constexpr double kMinEvidence = 50.0, kMinEvidenceSigmas = 3.0;
// All poses elsewhere must have less than this share of its evidence, or lie worse by so many
// standard errors.
constexpr double kRivalShare = 0.5, kClearSigmas = 1.5;
// Two hypotheses that end this close are one.
constexpr double kSame_m = 0.05, kSame_rad = 0.005;
// A pose so near to where it was expected needs no evidence where traffic hides the map.
constexpr double kExpected_m = 0.1;

Matrix6d AlignedCovariance() {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(kAlignedSigma_rad * kAlignedSigma_rad),
      Eigen::Vector3d::Constant(kAlignedSigma_m * kAlignedSigma_m);
  return variance.asDiagonal();
}

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d difference = a.Inverse() * b;
  return difference.t().norm() < kSame_m && difference.RotationAngle() < kSame_rad;
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
  // By how much a hypothesis must lie better than a more probable one. While lost none is: the one
  // with the most evidence is taken.
  double min_better_sigmas;
  bool by_evidence;
  bool is_searched = false;  // alignments without a guess were followed
  FoundPose best;
  // Of all hypotheses followed, the expected one first: where they ended, if the vehicle can have
  // come there, and how that lies on the map.
  std::vector<std::pair<Rigid3d, MapFit>> ends;

  // Follows a hypothesis; takes it if it is clearly better than the best so far.
  void Try(FrameTracker* tracker, const HealthMonitor& health, const PreprocessedFrame& frame,
           const PoseHypothesis& hypothesis, PoseOrigin origin) {
    TrackedPose tracked = tracker->Follow(frame, hypothesis, reference, executor, times);
    ++best.hypotheses;
    if (!is_reachable(tracked.T_odom_lidar)) return;
    const bool is_new = std::none_of(ends.begin(), ends.end(), [&](const auto& end) {
      return IsSame(end.first, tracked.T_odom_lidar);
    });
    ends.emplace_back(tracked.T_odom_lidar, tracked.fit);
    if (!is_new) return;
    const bool is_better = by_evidence ? HasMoreEvidence(tracked)
                                       : health.IsBetter(tracked, best.tracked, min_better_sigmas);
    if (!is_better) return;
    best.tracked = std::move(tracked);
    best.origin = origin;
  }

  bool HasMoreEvidence(const TrackedPose& tracked) const {
    if (!tracked.is_measured) return false;
    return !best.tracked.is_measured || Evidence(tracked.fit) > Evidence(best.tracked.fit);
  }
};

PoseFinder::PoseFinder(const SensorSetup& setup, Deskew deskew, const SlamOptions& options)
    : setup_(setup),
      options_(options),
      tracker_(setup, deskew, options),
      motion_(options.motion),
      before_restart_(options.motion),
      health_(options.health),
      traffic_(options.traffic) {}

void PoseFinder::TryMotions(const PreprocessedFrame& frame, const FrameContext& context,
                            Search* search) {
  std::vector<MotionPrediction> motions = AlternativeMotions(motion_, context.interval);
  for (size_t i = 1; i < motions.size(); ++i) {
    search->Try(&tracker_, health_, frame, PoseHypothesis::Of(motions[i], T_odom_prev_),
                PoseOrigin::kOtherMotion);
  }
}

Rigid3d PoseFinder::SearchCentre(const MotionPrediction& predicted) const {
  if (periods_unknown_ + periods_skipped_ == 0 || frames_ % 2 == 0) return T_odom_known_;
  // In the plane it was last seen in: heights held forward for seconds are worth nothing.
  const Rigid3d T_known_cur = T_odom_known_.Inverse() * T_odom_prev_ * predicted.T_prev_cur;
  return T_odom_known_ * Rigid3d::Translation(T_known_cur.t().x(), T_known_cur.t().y(), 0.0);
}

double PoseFinder::SearchYaw_rad() const {
  const double unknown_s = (periods_unknown_ + periods_skipped_) * setup_.lidar.sweep_s;
  return std::min(
      options_.search.max_yaw_window_rad,
      options_.search.yaw_window_rad + options_.search.lost_yaw_rate_rad_per_s * unknown_s);
}

void PoseFinder::TryAlignments(const PreprocessedFrame& frame, const FrameContext& context,
                               Search* search) {
  search->is_searched = true;
  const MotionPrediction predicted = Predict(context.interval);
  const KeyframeCloud cloud =
      tracker_.Compensate(frame, predicted.T_prev_cur, predicted.duration_s());
  const std::vector<Rigid3d> aligned = AlignWithoutGuess(
      AllPoints(cloud), search->reference.map, SearchCentre(predicted), options_.search.radius_m,
      SearchYaw_rad(), options_.search, search->executor);
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
    order.emplace_back(-Evidence(fit), i);
  }
  // Where the map knows much, also poses that are off gather evidence: the best alignments are
  // followed in any case.
  const size_t first = std::min(order.size(), kFirstAlignments);
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(first),
            order.end());  // most evidence first
  order.resize(std::min(order.size(), first + static_cast<size_t>(options_.search.max_followed)));
  std::vector<Rigid3d> best;
  for (const auto& [less_evidence, i] : order) best.push_back(T_odom_lidar[i]);
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

bool PoseFinder::IsAmongTraffic(const FrameInterval& interval, const Search& search) const {
  if (!road_ && interval.verdict != StampVerdict::kRegular) return false;
  if (!whole_ || !was_measured_ || !search.best.tracked.is_measured) return false;
  const Rigid3d innovation = search.T_odom_expected.Inverse() * search.best.tracked.T_odom_lidar;
  return innovation.t().norm() < kExpected_m;
}

// After a leap a pose is believed if its scan lies on the map as usual; while lost, if it also lies
// nowhere else within reach as well. Where the map hardly knows the place no scan lies as usual:
// then two frames in a row must lie there clearly better than anywhere else, one the continuation
// of the other.
Health PoseFinder::Judge(const FrameInterval& interval, const Search& search) const {
  const bool was_lost = !was_measured_ && !is_provisional_;
  const bool is_unfounded = search.best.tracked.fit.judged < options_.health.min_judged;
  if (is_provisional_ && is_unfounded) return Health::kBad;
  const Health health = health_.Judge(search.best.tracked, search.T_odom_expected, was_lost);
  if (IsAmongTraffic(interval, search)) return std::min(health, Health::kSuspicious);
  if (IsConfirmed(search)) return std::min(health, Health::kSuspicious);
  if (is_provisional_ && health == Health::kSuspicious) return Health::kBad;
  return was_lost && !IsClearWinner(search) ? Health::kBad : health;
}

bool PoseFinder::IsClearWinner(const Search& search) const {
  const TrackedPose& best = search.best.tracked;
  const double evidence = Evidence(best.fit);
  if (!search.is_searched || evidence < kMinEvidence) return false;
  if (EvidenceSigmas(best.fit) < kMinEvidenceSigmas) return false;
  return std::all_of(search.ends.begin(), search.ends.end(), [&](const auto& end) {
    if ((best.T_odom_lidar.t() - end.first.t()).norm() < kElsewhere_m) return true;
    if (Evidence(end.second) < kRivalShare * evidence) return true;
    // Along a hedge every pose has much: then the points judged in both decide.
    const FitComparison comparison = Compare(best.fit, end.second);
    return comparison.common >= options_.health.min_judged &&
           comparison.better > kClearSigmas * comparison.standard_error;
  });
}

bool PoseFinder::IsConfirmed(const Search& search) const {
  const Rigid3d& T_odom_continued = search.ends.front().first;
  const double apart_m = (search.best.tracked.T_odom_lidar.t() - T_odom_continued.t()).norm();
  return is_provisional_ && apart_m < kElsewhere_m && IsClearWinner(search);
}

FrameStatus PoseFinder::StatusOf(const PreprocessedFrame& frame, const TrackedPose& tracked,
                                 Health health) const {
  if (health == Health::kBad) {
    const bool has_data = frame.has_scan || tracked.is_measured;
    const Matrix6d covariance = covariance_unknown_ + tracked.start.covariance;
    const double sigma_m = std::sqrt(covariance.block<3, 3>(3, 3).trace());
    return has_data || sigma_m > kLostSigma_m ? FrameStatus::kLost : FrameStatus::kPredicted;
  }
  return frame.has_scan && HoldsAllDirections(tracked) ? FrameStatus::kTracked
                                                       : FrameStatus::kDegraded;
}

bool PoseFinder::IsWithoutData(const PreprocessedFrame& frame) {
  return !frame.has_scan && !frame.has_image;
}

FrameContext PoseFinder::SinceLastData(FrameContext context) const {
  if (periods_skipped_ == 0) return context;
  context.interval.periods += periods_skipped_;
  context.interval.nearest_periods += periods_skipped_;
  if (context.interval.verdict == StampVerdict::kRegular) {
    context.interval.verdict = StampVerdict::kGap;
  }
  return context;
}

FoundPose PoseFinder::Skip(const PreprocessedFrame& frame, const FrameContext& context) const {
  FoundPose found;
  found.tracked = HeldForward(frame, Predict(context.interval));
  found.origin = PoseOrigin::kNone;
  found.status = StatusOf(frame, found.tracked, Health::kBad);
  return found;
}

FoundPose PoseFinder::Find(const PreprocessedFrame& frame, const FrameContext& context,
                           const LocalMap& map, const LandmarkMap& landmarks,
                           const Executor& executor, StageTimes* times) {
  if (!has_first_) return First(frame, context);
  if (IsWithoutData(frame)) return Skip(frame, context);
  if (!motion_.known() && was_measured_ && last_.has_scan) {
    return FindStart(frame, context, landmarks, executor, times);
  }
  const MotionPrediction predicted = Expect(context.interval);
  const bool is_due = frames_ % options_.mapping.interval == 0;
  const auto is_reachable = [&](const Rigid3d& T_odom_lidar) {
    const int periods = periods_unknown_ + context.interval.periods - 1 + kMostLostPeriods;
    return IsReachable(motion_, periods, context.interval.period_s,
                       T_odom_known_.Inverse() * T_odom_lidar);
  };
  Search search{{T_odom_prev_, map, landmarks, is_due},
                executor,
                times,
                T_odom_prev_ * predicted.T_prev_cur,
                is_reachable,
                options_.health.min_better_sigmas,
                !was_measured_,
                false,
                {},
                {}};
  if (context.interval.verdict != StampVerdict::kRegular) {
    search.min_better_sigmas = std::min(search.min_better_sigmas, kDoubtfulStampSigmas);
  }
  PoseHypothesis hypothesis = PoseHypothesis::Of(predicted, T_odom_prev_);
  hypothesis.use_odometry = was_measured_ || is_provisional_;
  search.best.tracked = tracker_.Follow(frame, hypothesis, search.reference, executor, times);
  search.ends.emplace_back(search.best.tracked.T_odom_lidar, search.best.tracked.fit);

  Health health = Judge(context.interval, search);
  const bool is_doubtful =
      context.is_doubtful || !is_settled_ || context.interval.verdict != StampVerdict::kRegular;
  if (frame.has_scan && !IsAmongTraffic(context.interval, search) &&
      (is_doubtful || health != Health::kGood)) {
    if (was_measured_ || is_provisional_) TryMotions(frame, context, &search);
    health = Judge(context.interval, search);
    if (!was_measured_ || health != Health::kGood) TryAlignments(frame, context, &search);
    health = Judge(context.interval, search);
  }
  const bool is_clear = health == Health::kBad && IsClearWinner(search);
  FoundPose found = std::move(search.best);
  found.usual_misfit = health_.usual_misfit();
  found.status = StatusOf(frame, found.tracked, health);
  // The step makes up for what the traffic had carried the poses away by.
  const bool is_correction = was_carried_away_ && IsMeasured(found.status);
  if (is_correction) {
    found.beyond_covariance_m2 += slip_m_ * slip_m_.transpose();
  }
  found.is_uncertain =
      is_correction || (found.status == FrameStatus::kDegraded && IsStepUncertain(found.tracked));
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
  CompareWithSurroundings(frame, context, search.reference, executor, times, &found);
  return found;
}

void PoseFinder::Advance(PreprocessedFrame frame, const FoundPose& found,
                         const FrameContext& context) {
  if (has_first_ && IsWithoutData(frame)) {
    periods_skipped_ = context.interval.periods;
    was_carried_away_ = false;
    return;
  }
  ++frames_;
  periods_skipped_ = 0;
  const TrackedPose& tracked = found.tracked;
  const std::optional<Slip> slip = WatchTraffic(frame, found, context);
  was_carried_away_ = slip.has_value();
  if (slip) slip_m_ = slip->T_slip.t().head<2>();
  const bool among_traffic = whole_.has_value();
  if (among_traffic) {
    frame.features = std::move(whole_->features);
    frame.tracks = std::move(whole_->tracks);
    frame.depths = std::move(whole_->depths);
    tracker_.Advance(frame, tracker_.Compensate(frame, tracked.Motion(T_odom_prev_),
                                                tracked.start.duration_s()));
  } else {
    tracker_.Advance(frame, tracked.cloud);
  }
  const bool is_measured = IsMeasured(found.status);
  const bool is_settled =
      is_measured && !found.bridge && motion_.known() && found.origin == PoseOrigin::kPrediction;
  if (has_first_ && found.status != FrameStatus::kFirst) {
    const bool tells_velocity = (!found.bridge || !motion_.known()) &&
                                (found.origin != PoseOrigin::kAlignment || !motion_.known());
    if (is_measured && tells_velocity) {
      motion_.Update(slip ? slip->T_prev_cur : tracked.Motion(T_odom_prev_),
                     tracked.step_covariance, tracked.start.periods);
    } else {
      motion_.Coast(context.interval.periods);
    }
  }
  if (is_measured) {
    if (!among_traffic) health_.Learn(tracked);
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
  T_odom_prev_ = slip ? tracked.T_odom_lidar * slip->T_slip : tracked.T_odom_lidar;
  last_ = std::move(frame);
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
  traffic_.Forget();
  is_provisional_ = false;
  was_measured_ = true;
  periods_unknown_ = 0;
  covariance_unknown_.setZero();
  T_odom_known_ = T_odom_prev_;
}

}  // namespace tvl
