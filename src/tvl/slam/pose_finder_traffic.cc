// Among traffic: what certainly stands, the road or what is beside it, against the whole scan.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tvl/slam/pose_finder.h"

namespace tvl {
namespace {

// Further from what is expected, a motion over the road is not that of the vehicle.
constexpr double kExpectedSigmas = 4.0;
// In a jam nobody speeds up or brakes harder, without need.
constexpr double kJamAcceleration_m_s2 = 3.0;
// What moves about the vehicle does so for a second at least.
constexpr int kMovingThingsStay_frames = 10;
// By so much things in a jam move in a frame (3 m/s), and a pose that only they bear out with them.
constexpr double kCarriedAlong_m = 0.3;
// Until then what is expected may be what the scan of a drive that begins in a jam said.
constexpr int kFirst_frames = 10;
// Further apart, two motions are told apart by the tracks near the vehicle.
constexpr double kApart_m = 0.05;

}  // namespace

int PoseFinder::RemoveTraffic(const FrameContext& context, PreprocessedFrame* frame,
                              const Executor& executor) {
  whole_.reset();
  road_.reset();
  const bool goes_on = was_measured_ || is_provisional_;
  if (!traffic_.carries_estimate() || !frame->has_scan || !goes_on) return 0;
  const MotionPrediction predicted = Predict(context.interval);
  whole_ = Whole{frame->features, frame->tracks, frame->depths,
                 tracker_.EstimateOdometry(*frame, predicted, executor)};
  road_ = MeasureRoad(*frame, predicted.T_prev_cur, predicted);
  return traffic_.RemoveTraffic(road_, frame);
}

MotionPrediction PoseFinder::Expect(const FrameInterval& interval) const {
  const MotionPrediction predicted = Predict(interval);
  return road_ ? OverRoad(predicted, *road_) : predicted;
}

MotionPrediction PoseFinder::OverRoad(MotionPrediction motion, const RoadMotion& road) {
  motion.T_prev_cur = road.T_prev_cur;
  motion.covariance.middleRows<2>(3).setZero();
  motion.covariance.middleCols<2>(3).setZero();
  motion.covariance.block<2, 2>(3, 3) = CovarianceOf(road);
  return motion;
}

std::optional<RoadMotion> PoseFinder::MeasureRoad(const PreprocessedFrame& frame,
                                                  const Rigid3d& T_prev_cur,
                                                  const MotionPrediction& predicted) const {
  RoadGuess guess{T_prev_cur, predicted.T_prev_cur.t().head<2>(),
                  predicted.covariance.block<2, 2>(3, 3).inverse()};
  const std::optional<RoadMotion> road = tracker_.MeasureRoad(frame, guess);
  if (!road) return std::nullopt;
  // Before traffic was noticed, what is expected may come from it.
  const bool is_clear = StandingMotion::Of(*road).decides_alone ||
                        (frames_ < kFirst_frames && traffic_.HasMajority(*road));
  if (!traffic_.carries_estimate() && is_clear) return road;
  // What keeps pace with the vehicle, such as the shadow of the car before it, agrees, too.
  const Eigen::Matrix2d covariance = predicted.covariance.block<2, 2>(3, 3) + road->covariance_m2;
  const Eigen::Vector2d innovation_m = road->T_prev_cur.t().head<2>() - guess.expected_m;
  const double chi2 = innovation_m.dot(covariance.inverse() * innovation_m);
  double reach_m = options_.health.suspicious_innovation_m;
  if (traffic_.carries_estimate()) {
    const int periods = predicted.periods + traffic_.frames_without_road();
    const double sigma_m = std::sqrt(0.5 * road->covariance_m2.trace());
    reach_m = kJamAcceleration_m_s2 * predicted.period_s * predicted.period_s * periods +
              kExpectedSigmas * sigma_m;
  }
  const bool is_expected =
      chi2 < kExpectedSigmas * kExpectedSigmas && innovation_m.norm() < reach_m;
  return is_expected ? road : std::nullopt;
}

void PoseFinder::CompareWithSurroundings(const PreprocessedFrame& frame,
                                         const FrameContext& context,
                                         const TrackingReference& reference,
                                         const Executor& executor, StageTimes* times,
                                         FoundPose* found) {
  surroundings_.reset();
  if (!frame.has_scan || !frame.tracks.tracks.empty() || !IsMeasured(found->status)) return;
  const TrackedPose& tracked = found->tracked;
  const Rigid3d T_prev_cur = tracked.Motion(T_odom_prev_);
  const MotionPrediction expected = Expect(context.interval);
  const bool is_among = whole_ || traffic_.IsAmongMovingThings(frame.features, tracked.fit,
                                                               T_prev_cur, expected.duration_s());
  moving_things_frames_ =
      is_among ? kMovingThingsStay_frames : std::max(0, moving_things_frames_ - 1);
  if (moving_things_frames_ == 0) return;
  if (whole_) {  // traffic is left out already
    surroundings_ = traffic_.Surroundings(T_prev_cur, tracked.step_covariance, expected);
  } else {
    surroundings_ = MatchSurroundings(frame, expected, reference, executor, times);
  }
  const bool is_leap =
      (expected.T_prev_cur.t() - T_prev_cur.t()).norm() > options_.health.suspicious_innovation_m;
  if (surroundings_ && !is_leap && !traffic_.Contradicts(*surroundings_, T_prev_cur)) return;
  found->is_uncertain = true;
  found->beyond_covariance_m2.diagonal().array() += kCarriedAlong_m * kCarriedAlong_m;
}

std::optional<StandingMotion> PoseFinder::MatchSurroundings(const PreprocessedFrame& frame,
                                                            const MotionPrediction& expected,
                                                            const TrackingReference& reference,
                                                            const Executor& executor,
                                                            StageTimes* times) {
  PreprocessedFrame beside;  // there are no tracks, and of the scan its features are used
  beside.has_scan = frame.has_scan;
  beside.features = frame.features;
  traffic_.RemoveTraffic(std::nullopt, &beside);
  const PoseHypothesis hypothesis = PoseHypothesis::Of(expected, T_odom_prev_);
  const TrackedPose tracked = tracker_.Follow(beside, hypothesis, reference, executor, times);
  if (!tracked.is_measured) return std::nullopt;
  return traffic_.Surroundings(tracked.Motion(T_odom_prev_), tracked.step_covariance, expected);
}

std::optional<PoseFinder::Slip> PoseFinder::WatchTraffic(const PreprocessedFrame& frame,
                                                         const FoundPose& found,
                                                         const FrameContext& context) {
  const bool is_measured = !whole_ || whole_->odometry.status == EstimateStatus::kConverged ||
                           whole_->odometry.status == EstimateStatus::kNotConverged;
  if (!motion_.known() || !was_measured_ || !IsMeasured(found.status) || found.bridge ||
      !frame.has_scan || !is_measured) {
    traffic_.Interrupt();
    return std::nullopt;
  }
  const MotionPrediction predicted = Predict(context.interval);
  const Rigid3d T_prev_cur = found.tracked.Motion(T_odom_prev_);
  std::optional<RoadMotion> road;
  if (traffic_.MayBeAmongTraffic(T_prev_cur, predicted.duration_s())) {
    road = MeasureRoad(frame, T_prev_cur, predicted);
  }
  if (road && !whole_) {
    // Two motions, both with many tracks behind them: one of them is a shadow's.
    const double apart_m = (road->T_prev_cur.t() - T_prev_cur.t()).head<2>().norm();
    const auto agreeing = static_cast<double>(road->agreeing.size());
    if (apart_m > kApart_m && road->agreeing_with_guess > 0.5 * agreeing) road.reset();
  }
  std::optional<StandingMotion> standing = surroundings_;
  if (road) standing = StandingMotion::Of(*road);
  const Eigen::Vector2d slip_m = traffic_.Update(whole_ ? whole_->odometry.T_ref_body : T_prev_cur,
                                                 standing, predicted.duration_s());
  if (slip_m.isZero(0.0)) return std::nullopt;
  return Slip{Rigid3d::Translation(slip_m.x(), slip_m.y(), 0.0), standing->T_prev_cur};
}

}  // namespace tvl
