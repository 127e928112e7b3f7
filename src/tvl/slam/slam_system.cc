#include "tvl/slam/slam_system.h"

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/depth/corrected_extrinsics.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/lidar/deskew.h"

namespace tvl {
namespace {

// Of the first motion of a raw recording.
constexpr int kMaxStartPasses = 10;
constexpr double kStartPrecision_m = 0.002;

SlamOptions Checked(SlamOptions options) {
  options.Check();
  options.odometry.use_camera = options.odometry.use_camera && options.use_camera;
  options.mapping.scan_to_map.use_camera =
      options.mapping.scan_to_map.use_camera && options.use_camera;
  return options;
}

// A stamp that did not advance is not believed: the next period is counted from where it should
// have been.
Timestamp Advanced(Timestamp clock, Timestamp stamp, double period_s) {
  return clock < stamp ? stamp : Timestamp{clock.ns + Timestamp::FromSeconds(period_s).ns};
}

// The extrinsics that fit corrected points.
SensorSetup WithUsableExtrinsics(SensorSetup setup, const PreprocessingOptions& options) {
  if (options.calibrated_on_stored_points) {
    setup.calibration.T_cam_lidar = ExtrinsicsOfCorrectedPoints(
        setup.calibration.T_cam_lidar, setup.lidar.vertical_correction_rad);
  }
  return setup;
}

FeatureCloud CompensateFeatures(const std::vector<LaserFeature>& features,
                                const PredictedMotion& motion, Deskew deskew) {
  FeatureCloud cloud;
  std::vector<float> offset_s;
  for (const LaserFeature& feature : features) {
    cloud.points.push_back(feature.p_lidar);
    cloud.intensity.push_back(feature.intensity);
    offset_s.push_back(feature.time_offset_s);
  }
  if (deskew != Deskew::kNone) {
    cloud.points = DeskewPoints(cloud.points, offset_s, motion.T_prev_cur, motion.period_s);
  }
  return cloud;
}

int CountDepths(const VisualDepths& depths) {
  return static_cast<int>(std::count_if(depths.begin(), depths.end(), [](const VisualDepth& d) {
    return d.status == DepthStatus::kOk;
  }));
}

}  // namespace

const char* ToString(FrameStatus status) {
  switch (status) {
    case FrameStatus::kFirst:
      return "first";
    case FrameStatus::kTracked:
      return "tracked";
    case FrameStatus::kPredicted:
      return "predicted";
  }
  return "unknown";
}

SlamSystem::SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options)
    : setup_(WithUsableExtrinsics(setup, options.preprocessing)),
      deskew_(deskew),
      options_(Checked(options)),
      preprocessor_(setup_, deskew, options_.preprocessing, options_.use_camera),
      odometry_(setup_.calibration, options_.odometry),
      local_map_(options_.mapping.local_map),
      landmarks_(setup_.calibration, options_.mapping.landmarks),
      beams_(setup.lidar.rows(), options_.mapping.beams) {
  setup_.lidar.Check();
  motion_.period_s = setup.lidar.sweep_s;
}

FrameResult SlamSystem::ProcessFrame(const SensorFrame& frame, const Executor& executor) {
  const Stopwatch total;
  FrameResult result;
  result.id = frame.id;
  result.stamp = frame.stamp;
  result.faults = frame.faults;

  const PredictedMotion predicted = Predict(frame);
  PreprocessedFrame current =
      preprocessor_.Process(frame, predicted, beams_.offsets(), executor, &result.times);

  Stopwatch watch;
  result.odometry = EstimateMotion(current, predicted, executor);
  PredictedMotion motion{result.odometry.T_ref_body, predicted.period_s};
  const KeyframeCloud cloud = Compensate(current, motion);
  result.times.odometry_ms = watch.LapMs();

  const Rigid3d T_world_prev = trajectory_.empty() ? Rigid3d() : trajectory_.back().T_world_lidar;
  RefineAgainstMap(current, cloud, T_world_prev * motion.T_prev_cur, executor, &result);
  motion.T_prev_cur = T_world_prev.Inverse() * result.T_world_lidar;
  result.times.map_step_ms = watch.LapMs();

  has_velocity_ = !trajectory_.empty() && (has_velocity_ || result.status == FrameStatus::kTracked);
  motion_ = motion;
  path_m_ += motion.T_prev_cur.t().norm();
  clock_ = trajectory_.empty() ? frame.stamp : Advanced(clock_, frame.stamp, motion.period_s);
  trajectory_.push_back({frame.id, frame.stamp, result.T_world_lidar});
  UpdateMap(current, cloud, executor, &result);
  odometry_.Advance(current, cloud.edges.points, cloud.planes.points);
  result.times.map_update_ms = watch.LapMs();

  result.tracking = current.tracks.status;
  result.tracks = static_cast<int>(current.tracks.tracks.size());
  result.tracks_with_depth = CountDepths(current.depths);
  last_ = std::move(current);
  last_cloud_ = cloud;
  result.times.total_ms = total.ElapsedMs();
  return result;
}

PredictedMotion SlamSystem::Predict(const SensorFrame& frame) const {
  if (trajectory_.empty()) return {Rigid3d(), setup_.lidar.sweep_s};
  const double period_s = SecondsBetween(clock_, frame.stamp);
  if (period_s <= 0.0) return motion_;  // reported as a fault by the input
  return {Scale(period_s / motion_.period_s, motion_.T_prev_cur), period_s};
}

MotionEstimate SlamSystem::EstimateMotion(const PreprocessedFrame& frame,
                                          const PredictedMotion& predicted,
                                          const Executor& executor) {
  if (trajectory_.empty()) return MotionEstimate();
  const SweepBins bins = deskew_ == Deskew::kNone ? SweepBins::Compensated() : SweepBins::Raw();
  MotionEstimate estimate = odometry_.Estimate(frame, {predicted.T_prev_cur, has_velocity_}, bins,
                                               predicted.period_s, executor);
  if (has_velocity_ || deskew_ == Deskew::kNone || !last_.has_scan) return estimate;
  // No motion was known when the previous scan was compensated. The one found now does it better,
  // which makes it better itself: its error falls by half each time.
  for (int pass = 0; pass < kMaxStartPasses; ++pass) {
    if (estimate.status == EstimateStatus::kPredicted) break;
    const Rigid3d T_prev_cur = estimate.T_ref_body;
    CompensateLastAgain({T_prev_cur, predicted.period_s}, executor);
    estimate = odometry_.Estimate(frame, {T_prev_cur, true}, bins, predicted.period_s, executor);
    if ((estimate.T_ref_body.t() - T_prev_cur.t()).norm() < kStartPrecision_m) break;
  }
  return estimate;
}

void SlamSystem::CompensateLastAgain(const PredictedMotion& motion, const Executor& executor) {
  const KeyframeCloud cloud = Compensate(last_, motion);
  odometry_.Advance(last_, cloud.edges.points, cloud.planes.points);
  if (map_.keyframes.size() != 1 || map_.keyframes.back().frame != last_.id) return;
  Keyframe& keyframe = map_.keyframes.back();
  keyframe.cloud = std::make_shared<const KeyframeCloud>(cloud);
  local_map_ = LocalMap(options_.mapping.local_map);
  local_map_.Add(keyframe, executor);
}

KeyframeCloud SlamSystem::Compensate(const PreprocessedFrame& frame,
                                     const PredictedMotion& motion) const {
  return {CompensateFeatures(frame.features.less_sharp, motion, deskew_),
          CompensateFeatures(frame.features.less_flat, motion, deskew_)};
}

void SlamSystem::RefineAgainstMap(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                                  const Rigid3d& T_world_guess, const Executor& executor,
                                  FrameResult* result) {
  const bool is_first = trajectory_.empty();
  result->T_world_lidar = T_world_guess;
  result->step_covariance = result->odometry.covariance;
  const bool has_odometry = result->odometry.status == EstimateStatus::kConverged ||
                            result->odometry.status == EstimateStatus::kNotConverged;
  result->status = is_first       ? FrameStatus::kFirst
                   : has_odometry ? FrameStatus::kTracked
                                  : FrameStatus::kPredicted;
  const bool is_due = static_cast<int>(trajectory_.size()) % options_.mapping.interval == 0;
  if (is_first || local_map_.empty() || !is_due) return;
  const auto& options = options_.mapping.scan_to_map;
  const MapStepPoints points =
      ThinForMapStep(cloud.planes.points, cloud.edges.points, options.source_voxel_m);
  const PosePrior prior{T_world_guess, result->odometry.covariance,
                        result->odometry.T_ref_body.t().norm()};
  result->map_step = RefinePose(points, local_map_, landmarks_, frame.tracks,
                                setup_.calibration.T_cam_lidar, prior, options, executor);
  const std::vector<PlaneMatch> matches = std::move(result->map_step.planes);
  result->map_step.planes.clear();
  if (result->map_step.estimate.status == EstimateStatus::kPredicted) return;
  result->T_world_lidar = result->map_step.estimate.T_ref_body;
  result->step_covariance = result->map_step.estimate.covariance;
  result->status = FrameStatus::kTracked;
  CalibrateBeams(matches, points, frame.features.less_flat, result->T_world_lidar);
}

void SlamSystem::CalibrateBeams(const std::vector<PlaneMatch>& matches, const MapStepPoints& points,
                                const std::vector<LaserFeature>& features,
                                const Rigid3d& T_world_lidar) {
  std::vector<uint16_t> rings;
  rings.reserve(matches.size());
  for (const PlaneMatch& match : matches) {
    rings.push_back(features[points.plane_index[match.source]].ring);
  }
  beams_.Add(matches, rings, T_world_lidar, options_.mapping.scan_to_map.kernel_sigmas);
}

void SlamSystem::UpdateMap(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                           const Executor& executor, FrameResult* result) {
  if (options_.use_camera) landmarks_.Update(frame.tracks, frame.depths, result->T_world_lidar);
  if (!frame.has_scan || result->status == FrameStatus::kPredicted) return;
  const Rigid3d T_lastkeyframe_cur =
      map_.keyframes.empty()
          ? Rigid3d()
          : map_.keyframes.back().T_world_lidar.Inverse() * result->T_world_lidar;
  result->is_keyframe =
      IsKeyframe(T_lastkeyframe_cur, map_.keyframes.size(), options_.mapping.keyframes);
  if (result->is_keyframe) AddKeyframe(*result, cloud, executor);
}

void SlamSystem::AddKeyframe(const FrameResult& result, const KeyframeCloud& cloud,
                             const Executor& executor) {
  Keyframe keyframe;
  keyframe.id = {0, static_cast<int32_t>(map_.keyframes.size())};
  keyframe.frame = result.id;
  keyframe.stamp = result.stamp;
  keyframe.T_world_lidar = result.T_world_lidar;
  keyframe.path_m = path_m_;
  keyframe.cloud = std::make_shared<const KeyframeCloud>(cloud);
  local_map_.Add(keyframe, executor);
  map_.keyframes.push_back(std::move(keyframe));
}

MapCloud BuildMapCloud(const Map& map, double voxel_m) {
  TVL_CHECK_INPUT(voxel_m > 0.0) << "map voxel: must be positive, is " << voxel_m;
  VoxelHash<char> seen;
  MapCloud cloud;
  for (const Keyframe& keyframe : map.keyframes) {
    for (const FeatureCloud* part : {&keyframe.cloud->planes, &keyframe.cloud->edges}) {
      for (size_t i = 0; i < part->points.size(); ++i) {
        const Eigen::Vector3d p = keyframe.T_world_lidar * part->points[i].cast<double>();
        char& taken = seen[VoxelKey::Of(p, voxel_m)];
        if (taken != 0) continue;
        taken = 1;
        cloud.points.push_back(p.cast<float>());
        cloud.intensity.push_back(part->intensity[i]);
      }
    }
  }
  return cloud;
}

}  // namespace tvl
