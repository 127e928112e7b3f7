#include "tvl/slam/slam_system.h"

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/depth/corrected_extrinsics.h"
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

// The motion between two poses of the odometry frame, with drift.
Rigid3d MotionWithDrift(const Rigid3d& T_odom_prev, const Rigid3d& T_odom_cur,
                        const InjectedDriftOptions& drift) {
  const double length_m = (T_odom_cur.t() - T_odom_prev.t()).norm();
  Vector6d turn = Vector6d::Zero();
  turn[2] = length_m * drift.yaw_rad_per_m;
  const Eigen::Vector3d shift_m =
      length_m * Eigen::Vector3d(drift.x_share, drift.y_share, drift.z_share);
  const Rigid3d shifted(T_odom_cur.q(), T_odom_cur.t() + shift_m);
  return T_odom_prev.Inverse() * shifted * Rigid3d::Exp(turn);
}

LocalMapMember MemberOf(const Map& map, size_t index) {
  const Keyframe& keyframe = map.keyframes[index];
  return {keyframe.id.index, keyframe.path_m, keyframe.T_odom_lidar,
          map.store->Cloud(keyframe.id.index)};
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

SlamSystem::SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options,
                       bool in_background)
    : setup_(WithUsableExtrinsics(setup, options.preprocessing)),
      deskew_(deskew),
      options_(Checked(options)),
      preprocessor_(setup_, deskew, options_.preprocessing, options_.use_camera),
      odometry_(setup_.calibration, options_.odometry),
      local_map_(options_.mapping.local_map),
      landmarks_(setup_.calibration, options_.mapping.landmarks),
      beams_(setup.lidar.rows(), options_.mapping.beams),
      loop_thread_(in_background && options_.loops.enabled) {
  setup_.lidar.Check();
  map_.store = std::make_shared<KeyframeStore>(options_.mapping.store);
  if (options_.loops.enabled) {
    loop_closer_ = std::make_shared<LoopCloser>(options_.loops, setup_.calibration, map_.store);
  }
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

  const Rigid3d T_odom_prev = path_.empty() ? Rigid3d() : path_.back().T_odom_lidar;
  RefineAgainstMap(current, cloud, T_odom_prev * motion.T_prev_cur, executor, &result);
  motion.T_prev_cur = T_odom_prev.Inverse() * result.T_odom_lidar;
  result.times.map_step_ms = watch.LapMs();

  Advance(result, motion);
  result.is_keyframe = UpdateLandmarks(current, result);
  if (result.is_keyframe) {
    ImageFeatures image;  // for the visual search alone
    if (options_.loops.enabled && options_.loops.use_visual) {
      image = preprocessor_.Describe(frame, current, motion);
    }
    AddKeyframe(result, {cloud, std::move(image)}, executor);
  }
  odometry_.Advance(current, cloud.edges.points, cloud.planes.points);
  result.times.map_update_ms = watch.LapMs();

  if (result.is_keyframe && loop_closer_ != nullptr) CloseLoops(executor);
  path_.push_back(
      {frame.id, frame.stamp, static_cast<int>(map_.keyframes.size()) - 1, result.T_odom_lidar});
  result.T_world_lidar = map_.keyframes.empty()
                             ? result.T_odom_lidar
                             : ToWorld(map_.keyframes.back(), result.T_odom_lidar);
  result.times.loops_ms = watch.LapMs();

  result.tracking = current.tracks.status;
  result.tracks = static_cast<int>(current.tracks.tracks.size());
  result.tracks_with_depth = CountDepths(current.depths);
  last_ = std::move(current);
  last_cloud_ = cloud;
  result.times.total_ms = total.ElapsedMs();
  return result;
}

void SlamSystem::Advance(const FrameResult& result, const PredictedMotion& motion) {
  const bool is_first = path_.empty();
  has_velocity_ = !is_first && (has_velocity_ || result.status == FrameStatus::kTracked);
  motion_ = motion;
  path_m_ += motion.T_prev_cur.t().norm();
  clock_ = is_first ? result.stamp : Advanced(clock_, result.stamp, motion.period_s);
  const Matrix6d adjoint = motion.T_prev_cur.Inverse().Adjoint();
  keyframe_covariance_ =
      (adjoint * keyframe_covariance_ * adjoint.transpose() + result.step_covariance).eval();
}

PredictedMotion SlamSystem::Predict(const SensorFrame& frame) const {
  if (path_.empty()) return {Rigid3d(), setup_.lidar.sweep_s};
  const double period_s = SecondsBetween(clock_, frame.stamp);
  if (period_s <= 0.0) return motion_;  // reported as a fault by the input
  return {Scale(period_s / motion_.period_s, motion_.T_prev_cur), period_s};
}

MotionEstimate SlamSystem::EstimateMotion(const PreprocessedFrame& frame,
                                          const PredictedMotion& predicted,
                                          const Executor& executor) {
  if (path_.empty()) return MotionEstimate();
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
  KeyframePayload payload = *map_.store->Get(0);
  payload.cloud = cloud;
  map_.store->Put(0, std::make_shared<const KeyframePayload>(std::move(payload)));
  local_map_ = LocalMap(options_.mapping.local_map);
  local_map_.Add(MemberOf(map_, 0), executor);
}

KeyframeCloud SlamSystem::Compensate(const PreprocessedFrame& frame,
                                     const PredictedMotion& motion) const {
  return {CompensateFeatures(frame.features.less_sharp, motion, deskew_),
          CompensateFeatures(frame.features.less_flat, motion, deskew_)};
}

void SlamSystem::RefineAgainstMap(const PreprocessedFrame& frame, const KeyframeCloud& cloud,
                                  const Rigid3d& T_odom_guess, const Executor& executor,
                                  FrameResult* result) {
  const bool is_first = path_.empty();
  result->T_odom_lidar = T_odom_guess;
  result->step_covariance = result->odometry.covariance;
  const bool has_odometry = result->odometry.status == EstimateStatus::kConverged ||
                            result->odometry.status == EstimateStatus::kNotConverged;
  result->status = is_first       ? FrameStatus::kFirst
                   : has_odometry ? FrameStatus::kTracked
                                  : FrameStatus::kPredicted;
  const bool is_due = static_cast<int>(path_.size()) % options_.mapping.interval == 0;
  if (is_first || local_map_.empty() || !is_due) return;
  const auto& options = options_.mapping.scan_to_map;
  const MapStepPoints points =
      ThinForMapStep(cloud.planes.points, cloud.edges.points, options.source_voxel_m);
  const PosePrior prior{T_odom_guess, result->odometry.covariance,
                        result->odometry.T_ref_body.t().norm()};
  result->map_step = RefinePose(points, local_map_, landmarks_, frame.tracks,
                                setup_.calibration.T_cam_lidar, prior, options, executor);
  const std::vector<PlaneMatch> matches = std::move(result->map_step.planes);
  result->map_step.planes.clear();
  if (result->map_step.estimate.status == EstimateStatus::kPredicted) return;
  result->T_odom_lidar = result->map_step.estimate.T_ref_body;
  result->step_covariance = result->map_step.estimate.covariance;
  result->status = FrameStatus::kTracked;
  CalibrateBeams(matches, points, frame.features.less_flat, result->T_odom_lidar);
}

void SlamSystem::CalibrateBeams(const std::vector<PlaneMatch>& matches, const MapStepPoints& points,
                                const std::vector<LaserFeature>& features,
                                const Rigid3d& T_odom_lidar) {
  std::vector<uint16_t> rings;
  rings.reserve(matches.size());
  for (const PlaneMatch& match : matches) {
    rings.push_back(features[points.plane_index[match.source]].ring);
  }
  beams_.Add(matches, rings, T_odom_lidar, options_.mapping.scan_to_map.kernel_sigmas);
}

bool SlamSystem::UpdateLandmarks(const PreprocessedFrame& frame, const FrameResult& result) {
  if (options_.use_camera) landmarks_.Update(frame.tracks, frame.depths, result.T_odom_lidar);
  if (!frame.has_scan || result.status == FrameStatus::kPredicted) return false;
  const Rigid3d T_lastkeyframe_cur =
      map_.keyframes.empty() ? Rigid3d()
                             : map_.keyframes.back().T_odom_lidar.Inverse() * result.T_odom_lidar;
  return IsKeyframe(T_lastkeyframe_cur, map_.keyframes.size(), options_.mapping.keyframes);
}

void SlamSystem::AddKeyframe(const FrameResult& result, KeyframePayload payload,
                             const Executor& executor) {
  Keyframe keyframe;
  keyframe.id = {0, static_cast<int32_t>(map_.keyframes.size())};
  keyframe.frame = result.id;
  keyframe.stamp = clock_;
  keyframe.path_m = path_m_;
  keyframe.T_odom_lidar = result.T_odom_lidar;
  keyframe.T_world_lidar = result.T_odom_lidar;
  if (!map_.keyframes.empty()) {
    const Keyframe& previous = map_.keyframes.back();
    keyframe.T_prev_cur =
        MotionWithDrift(previous.T_odom_lidar, result.T_odom_lidar, options_.loops.injected_drift);
    keyframe.covariance = keyframe_covariance_;
    keyframe.T_world_lidar = previous.T_world_lidar * keyframe.T_prev_cur;
  }
  keyframe_covariance_.setZero();
  map_.store->Put(keyframe.id.index, std::make_shared<const KeyframePayload>(std::move(payload)));
  map_.keyframes.push_back(keyframe);
  local_map_.Add(MemberOf(map_, map_.keyframes.size() - 1), executor);
}

void SlamSystem::CloseLoops(const Executor& executor) {
  if (loop_fault_.empty()) {
    // With its payload: that of the first keyframe may be replaced meanwhile.
    const Keyframe& newest = map_.keyframes.back();
    loop_thread_.Give([closer = loop_closer_, newest, payload = map_.store->Get(newest.id.index)] {
      return closer->Process(newest, *payload);
    });
  }
  const size_t lag = static_cast<size_t>(options_.loops.lag_keyframes);
  if (loop_fault_.empty() && loop_thread_.pending() <= lag) return;
  try {
    Connect(ApplyNext(), executor);        // after a fault: lets go of earlier passes
  } catch (const std::exception& error) {  // an earlier pass cannot be read back
    loop_fault_ = error.what();
  }
}

std::vector<int> SlamSystem::ApplyNext() {
  if (loop_thread_.pending() == 0) return {};
  try {
    const LoopUpdate update = loop_thread_.Take();
    if (!loop_fault_.empty()) return {};  // of work given before the fault was known
    Apply(update);
    return update.connected;
  } catch (const std::exception& error) {
    if (loop_fault_.empty()) loop_fault_ = error.what();
    return {};
  }
}

void SlamSystem::Connect(const std::vector<int>& keyframes, const Executor& executor) {
  const Keyframe& newest = map_.keyframes.back();
  const Rigid3d T_odom_world = newest.T_odom_lidar * newest.T_world_lidar.Inverse();
  std::vector<LocalMap::Connected> wanted;
  for (const int index : keyframes) {
    const Keyframe& keyframe = map_.keyframes[static_cast<size_t>(index)];
    const double apart_m = (keyframe.T_world_lidar.t() - newest.T_world_lidar.t()).norm();
    if (apart_m >= options_.mapping.local_map.connected_radius_m) continue;
    wanted.push_back({index, T_odom_world * keyframe.T_world_lidar});
  }
  local_map_.Connect(
      wanted, [this](int index) { return map_.store->Cloud(index); }, executor);
}

void SlamSystem::Apply(const LoopUpdate& update) {
  for (size_t i = 0; i < update.T_world_lidar.size(); ++i) {
    map_.keyframes[i].T_world_lidar = update.T_world_lidar[i];
  }
  if (update.T_world_lidar.empty()) return;
  for (size_t i = update.T_world_lidar.size(); i < map_.keyframes.size(); ++i) {
    map_.keyframes[i].T_world_lidar =
        map_.keyframes[i - 1].T_world_lidar * map_.keyframes[i].T_prev_cur;
  }
}

const LoopReport& SlamSystem::loops() const {
  static const LoopReport none;
  return loop_closer_ == nullptr ? none : loop_closer_->report();
}

void SlamSystem::Finish(SecondLook second_look) {
  if (loop_closer_ == nullptr) return;
  while (loop_thread_.pending() > 0) ApplyNext();
  for (const auto step : {&LoopCloser::LookAgain, &LoopCloser::Polish}) {
    if (step == &LoopCloser::LookAgain && second_look == SecondLook::kNo) continue;
    if (!loop_fault_.empty()) return;
    loop_thread_.Give([closer = loop_closer_, step] { return ((*closer).*step)(); });
    ApplyNext();
  }
}

}  // namespace tvl
