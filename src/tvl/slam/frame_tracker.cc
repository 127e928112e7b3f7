#include "tvl/slam/frame_tracker.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/stopwatch.h"
#include "tvl/lidar/deskew.h"

namespace tvl {
namespace {

FeatureCloud CompensateFeatures(const std::vector<LaserFeature>& features,
                                const Rigid3d& T_prev_cur, double duration_s, Deskew deskew) {
  FeatureCloud cloud;
  std::vector<float> offset_s;
  cloud.points.reserve(features.size());
  cloud.intensity.reserve(features.size());
  offset_s.reserve(features.size());
  for (const LaserFeature& feature : features) {
    cloud.points.push_back(feature.p_lidar);
    cloud.intensity.push_back(feature.intensity);
    offset_s.push_back(feature.time_offset_s);
  }
  if (deskew != Deskew::kNone) {
    cloud.points = DeskewPoints(cloud.points, offset_s, T_prev_cur, duration_s);
  }
  return cloud;
}

FeatureCloud WithoutLabels(const FeatureCloud& cloud, const std::vector<LaserFeature>& features,
                           const std::set<int32_t>& labels) {
  FeatureCloud kept;
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    if (labels.count(features[i].label) > 0) continue;
    kept.points.push_back(cloud.points[i]);
    kept.intensity.push_back(cloud.intensity[i]);
  }
  return kept;
}

// A motion that differs by this much bends a raw scan by half of it at either end: as much as the
// noise of a range.
constexpr double kCompensatedAnew_m = 0.02, kCompensatedAnew_rad = 0.002;  // 2 cm at 10 m
// More than any driving explains in a tenth of a second (20 m/s^2): the scan took another time than
// the motion, which is for another hypothesis to say.
constexpr double kOtherPeriod_m = 0.2;
// Share of the strongest direction's information below which the camera does not hold a direction
// that the lidar does not hold either.
constexpr double kHeldByCamera = 0.0005;

const MotionEstimate& FinalEstimate(const TrackedPose& tracked) {
  const MotionEstimate& by_map = tracked.map_step.estimate;
  const bool has_map_step =
      by_map.status != EstimateStatus::kFirst && by_map.status != EstimateStatus::kPredicted;
  return has_map_step ? by_map : tracked.odometry;
}

}  // namespace

MapStepPoints PointsForMapStep(const KeyframeCloud& cloud, const PreprocessedFrame& frame,
                               const LidarModel& lidar, double voxel_m) {
  MapStepPoints points = ThinForMapStep(cloud.planes.points, cloud.edges.points, voxel_m);
  if (!lidar.rows_are_beams) return points;
  for (const uint32_t i : points.plane_index) {
    points.plane_beam.push_back(frame.features.less_flat[i].ring);
  }
  return points;
}

bool HoldsAllDirections(const TrackedPose& tracked) {
  const MotionEstimate& estimate = FinalEstimate(tracked);
  return std::all_of(estimate.weak.begin(), estimate.weak.end(), [](const WeakDirection& weak) {
    return weak.camera_strength > kHeldByCamera;
  });
}

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

FrameTracker::FrameTracker(const SensorSetup& setup, Deskew deskew, const SlamOptions& options)
    : setup_(setup),
      deskew_(deskew),
      options_(options),
      odometry_(setup.calibration, options.odometry) {}

void FrameTracker::Advance(const PreprocessedFrame& frame, const KeyframeCloud& cloud) {
  odometry_.Advance(frame, cloud.edges.points, cloud.planes.points);
}

KeyframeCloud FrameTracker::Compensate(const PreprocessedFrame& frame, const Rigid3d& T_prev_cur,
                                       double duration_s) const {
  return {CompensateFeatures(frame.features.less_sharp, T_prev_cur, duration_s, deskew_),
          CompensateFeatures(frame.features.less_flat, T_prev_cur, duration_s, deskew_)};
}

KeyframeCloud FrameTracker::WithoutNewClusters(const PreprocessedFrame& frame,
                                               const TrackedPose& tracked) const {
  const std::set<int32_t>& labels = tracked.known_fit.new_clusters;
  if (labels.empty()) return tracked.cloud;
  return {WithoutLabels(tracked.cloud.edges, frame.features.less_sharp, labels),
          WithoutLabels(tracked.cloud.planes, frame.features.less_flat, labels)};
}

bool FrameTracker::NeedsOdometry(const PoseHypothesis& hypothesis,
                                 const TrackingReference& reference) const {
  // Elsewhere the previous frame's pose says nothing of this one's.
  if (!hypothesis.use_odometry) return false;
  if (options_.odometry.enabled || !hypothesis.motion.known) return true;
  // On the map of a single scan the pose is drawn to where its rings lie on each other.
  return reference.map.size() < 2 || !reference.map_step_is_due;
}

void FrameTracker::EstimateMotion(const PreprocessedFrame& frame, const PoseHypothesis& hypothesis,
                                  const TrackingReference& reference, const Executor& executor,
                                  TrackedPose* tracked) {
  const MotionPrediction& motion = hypothesis.motion;
  tracked->start = motion;
  if (!NeedsOdometry(hypothesis, reference)) {
    tracked->odometry.status = EstimateStatus::kPredicted;
    tracked->odometry.T_ref_body = motion.T_prev_cur;
    tracked->odometry.covariance = hypothesis.covariance;
    tracked->T_odom_lidar = hypothesis.T_odom_lidar;
  } else {
    tracked->odometry = EstimateOdometry(frame, motion, executor);
    tracked->T_odom_lidar = reference.T_odom_prev * tracked->odometry.T_ref_body;
  }
  tracked->is_measured = tracked->odometry.status == EstimateStatus::kConverged ||
                         tracked->odometry.status == EstimateStatus::kNotConverged;
  tracked->step_covariance = tracked->odometry.covariance;
  tracked->cloud = Compensate(frame, tracked->odometry.T_ref_body, motion.duration_s());
}

MotionEstimate FrameTracker::EstimateOdometry(const PreprocessedFrame& frame,
                                              const MotionPrediction& motion,
                                              const Executor& executor) {
  const SweepBins bins = is_compensated() ? SweepBins::Compensated() : SweepBins::Raw();
  return odometry_.Estimate(frame, {motion.T_prev_cur, motion.covariance, motion.known}, bins,
                            motion.duration_s(), executor);
}

TrackedPose FrameTracker::Follow(const PreprocessedFrame& frame, const PoseHypothesis& hypothesis,
                                 const TrackingReference& reference, const Executor& executor,
                                 StageTimes* times) {
  Stopwatch watch;
  TrackedPose tracked;
  EstimateMotion(frame, hypothesis, reference, executor, &tracked);
  times->odometry_ms += watch.LapMs();
  const Rigid3d T_odom_prior = tracked.T_odom_lidar;
  RefineAgainstMap(frame, T_odom_prior, reference, executor, &tracked);
  if (!is_compensated() && tracked.is_measured && hypothesis.use_odometry) {
    // The map step knows the motion better: the scan enters the map as that motion compensates it,
    // and is matched anew where that makes a difference.
    const Rigid3d T_prev_cur = tracked.Motion(reference.T_odom_prev);
    const Rigid3d change = tracked.odometry.T_ref_body.Inverse() * T_prev_cur;
    tracked.cloud = Compensate(frame, T_prev_cur, hypothesis.motion.duration_s());
    const bool bends =
        change.t().norm() > kCompensatedAnew_m || change.RotationAngle() > kCompensatedAnew_rad;
    if (bends && change.t().norm() < kOtherPeriod_m) {
      TrackedPose anew = tracked;
      RefineAgainstMap(frame, T_odom_prior, reference, executor, &anew);
      if (anew.map_step.estimate.status != EstimateStatus::kPredicted) tracked = std::move(anew);
      tracked.cloud =
          Compensate(frame, tracked.Motion(reference.T_odom_prev), hypothesis.motion.duration_s());
    }
  }
  if (frame.has_scan && !reference.map.empty()) {
    const std::vector<FitSample> sample =
        SampleForFit(frame.features.less_flat, options_.mapping.fit);
    tracked.fit = FitToMap(tracked.cloud.planes.points, sample, reference.map, tracked.T_odom_lidar,
                           options_.mapping.fit);
    tracked.known_fit = FitWithoutNewClusters(tracked.fit);
  }
  times->map_step_ms += watch.LapMs();
  return tracked;
}

void FrameTracker::RefineAgainstMap(const PreprocessedFrame& frame, const Rigid3d& T_odom_prior,
                                    const TrackingReference& reference, const Executor& executor,
                                    TrackedPose* tracked) const {
  if (reference.map.empty() || !reference.map_step_is_due) return;
  const auto& options = options_.mapping.scan_to_map;
  const MapStepPoints points =
      PointsForMapStep(tracked->cloud, frame, setup_.lidar, options.source_voxel_m);
  const PosePrior prior{T_odom_prior, tracked->odometry.covariance,
                        tracked->odometry.T_ref_body.t().norm()};
  tracked->map_step = RefinePose(points, reference.map, reference.landmarks, frame.tracks,
                                 setup_.calibration, prior, options, executor);
  if (tracked->map_step.estimate.status == EstimateStatus::kPredicted) {
    tracked->map_step.planes.clear();
    return;
  }
  tracked->T_odom_lidar = tracked->map_step.estimate.T_ref_body;
  tracked->step_covariance = tracked->map_step.estimate.covariance;
  tracked->is_measured = true;
  tracked->map_step_source.clear();
  for (const PlaneMatch& match : tracked->map_step.planes) {
    tracked->map_step_source.push_back(points.plane_index[match.source]);
  }
}

}  // namespace tvl
