#include "tvl/slam/slam_system.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/depth/corrected_extrinsics.h"
#include "tvl/slam/frame_check.h"

namespace tvl {
namespace {

// The map begins anew when so many scans in a row did not find the pose, and the vehicle may have
// left its surroundings (PoseFinder::MayHaveTravelled_m): the next scans will not do better.
constexpr int kRestartAfterScans = 15;
constexpr double kSurroundings_m = 15.0;

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

SlamSystem::SlamSystem(const SensorSetup& setup, Deskew deskew, const SlamOptions& options,
                       bool in_background)
    : setup_(WithUsableExtrinsics(setup, options.preprocessing)),
      options_(Checked(options)),
      preprocessor_(setup_, deskew, options_.preprocessing, options_.use_camera),
      finder_(setup_, deskew, options_),
      clock_(setup.lidar.sweep_s, options_.clock),
      local_map_(options_.mapping.local_map),
      landmarks_(setup_.calibration, options_.mapping.landmarks),
      moving_tracks_(setup_.calibration, options_.mapping.moving_tracks),
      beams_(setup.lidar.rows_are_beams ? setup.lidar.rows() : 0, options_.mapping.beams),
      extrinsics_(setup_.calibration, options_.extrinsics),
      lidar_only_(setup_.calibration, options_.mapping.scan_to_map, options_.mapping.local_map,
                  options_.mapping.keyframes),
      calibration_check_(setup_.calibration),
      uncertainty_(options_.uncertainty),
      known_{0, 0.0, uncertainty_},
      loop_thread_(in_background && options_.loops.enabled) {
  setup_.lidar.Check();
  map_.store = std::make_shared<KeyframeStore>(options_.mapping.store);
  if (options_.loops.enabled) {
    loop_closer_ = std::make_shared<LoopCloser>(options_.loops, setup_.calibration, map_.store);
  }
  last_motion_.period_s = setup.lidar.sweep_s;
  UseExtrinsics();
}

FrameResult SlamSystem::ProcessFrame(const SensorFrame& input, const Executor& executor,
                                     FrameTrace* trace) {
  const Stopwatch total;
  FrameContext context;
  const SensorFrame checked = WithoutOddData(input, setup_);
  const SensorFrame frame = WithoutRepetitions(checked, &context);
  context = finder_.SinceLastData(context);
  FrameResult result;
  result.id = frame.id;
  result.stamp = frame.stamp;
  result.faults = frame.faults;
  if (frame.scan == nullptr && checked.scan != nullptr && frame.image.empty()) {
    return RepeatLastPose(std::move(result));
  }

  const MotionPrediction predicted = finder_.Predict(context.interval);
  if (!frame.image.empty()) image_delay_s_ = frame.image_delay_s;
  UseDelay({predicted.T_prev_cur, predicted.duration_s()});
  PreprocessedFrame current =
      preprocessor_.Process(frame, {predicted.T_prev_cur, predicted.duration_s()}, beams_.offsets(),
                            executor, &result.times, &result.faults);
  const FeatureTracks all_tracks = current.tracks;
  const VisualDepths all_depths = current.depths;
  result.tracks_moving = moving_tracks_.Remove(&current.tracks, &current.depths);
  result.tracks_moving += finder_.RemoveTraffic(context, &current, executor);
  const FoundPose found =
      finder_.Find(current, context, local_map_, landmarks_, executor, &result.times);
  Describe(current, found, &result);

  Stopwatch watch;
  if (found.previous_cloud) ReplaceLastCloud(*found.previous_cloud, executor);
  Advance(found, &result);
  if (IsMeasured(result.status)) {
    CalibrateBeams(found, current);
    if (options_.use_camera) {
      UseDelay(last_motion_);
      if (found.bridge) ForgetViews();
      moving_tracks_.Update(all_tracks, all_depths, result.T_odom_lidar);
      landmarks_.Update(current.tracks, current.depths, result.T_odom_lidar);
      CalibrateExtrinsics(current, all_tracks, found, executor, &result);
    }
  }
  result.is_keyframe = IsDueKeyframe(current, result);
  if (result.is_keyframe) {
    AddKeyframe(result, {finder_.CloudForMap(current, found), DescribeImage(frame, current)},
                executor);
  }
  result.times.map_update_ms = watch.LapMs();

  if (result.is_keyframe && loop_closer_ != nullptr) CloseLoops(executor);
  path_.push_back(
      {frame.id, frame.stamp, static_cast<int>(map_.keyframes.size()) - 1, result.T_odom_lidar});
  if (IsMeasured(result.status)) known_ = {path_.size() - 1, path_m_, uncertainty_};
  result.T_world_lidar = InWorld(result.T_odom_lidar);
  result.times.loops_ms = watch.LapMs();

  last_cloud_ = found.tracked.cloud;
  last_status_ = result.status;
  const bool has_data = current.has_scan || current.has_image;
  if (trace != nullptr && !has_data) trace->frame = current;
  finder_.Advance(std::move(current), found, context);
  if (finder_.was_carried_away()) {
    landmarks_ = LandmarkMap(setup_.calibration, options_.mapping.landmarks);
    ForgetViews();
  }
  if (lost_scans_ >= kRestartAfterScans && finder_.last_frame().has_scan &&
      finder_.MayHaveTravelled_m() > kSurroundings_m) {
    Restart(result, executor);
    result.map_begins_anew = true;
  }
  if (found.is_uncertain) result.status = FrameStatus::kPredicted;  // what was measured is kept
  if (trace != nullptr) {
    if (has_data) trace->frame = finder_.last_frame();
    trace->motion = last_motion_;
  }
  result.times.total_ms = total.ElapsedMs();
  return result;
}

SensorFrame SlamSystem::WithoutRepetitions(SensorFrame frame, FrameContext* context) {
  const std::string name = "frame " + std::to_string(frame.id);
  if (!options_.use_camera || !setup_.has_camera || calibration_check_.has_contradiction()) {
    frame.image.release();
  }
  if (!frame.image.empty()) {
    const std::string odd = calibration_check_.CheckImage(frame.image.cols, frame.image.rows);
    if (!odd.empty())
      frame.faults.push_back({FrameFault::Kind::kOddCalibration, name + ": " + odd});
  }
  const Repetition repetition = repetition_.Check(frame);
  context->interval = clock_.Advance(frame.stamp);
  const FrameInterval& interval = context->interval;
  stamp_ = path_.empty() ? frame.stamp : Advanced(stamp_, frame.stamp, interval.period_s);
  std::ostringstream passed;
  passed << std::setprecision(6) << interval.stamp_s << " s after the frame before";
  if (interval.verdict == StampVerdict::kGap) {
    frame.faults.push_back({FrameFault::Kind::kTimeGap, name + ": stamped " + passed.str() + ", " +
                                                            std::to_string(interval.periods) +
                                                            " turns of the lidar"});
  } else if (interval.verdict == StampVerdict::kIrregular) {
    frame.faults.push_back({FrameFault::Kind::kIrregularTime,
                            name + ": stamped " + passed.str() +
                                ", which is no whole number of turns of the lidar: not believed"});
  }
  if (repetition.scan) {
    frame.faults.push_back({FrameFault::Kind::kRepeatedScan,
                            name + ": its scan is that of the frame before: left out"});
    frame.scan = nullptr;
  }
  if (repetition.image) {
    if (!repetition.scan) {
      frame.faults.push_back({FrameFault::Kind::kRepeatedImage,
                              name + ": its image is that of a frame before: left out"});
    }
    frame.image.release();
  }
  context->is_doubtful = was_repeated_;
  was_repeated_ = repetition.scan && frame.image.empty();
  return frame;
}

// Nothing new was measured: the vehicle is where it was, as far as anybody knows.
FrameResult SlamSystem::RepeatLastPose(FrameResult result) {
  result.status = last_status_;
  result.T_odom_lidar = path_.empty() ? Rigid3d() : path_.back().T_odom_lidar;
  result.T_world_lidar = InWorld(result.T_odom_lidar);
  result.pose_covariance = uncertainty_.SinceFirst();
  result.noise_covariance = uncertainty_.AgainstMap();
  path_.push_back(
      {result.id, result.stamp, static_cast<int>(map_.keyframes.size()) - 1, result.T_odom_lidar});
  if (IsMeasured(last_status_)) known_.path = path_.size() - 1;
  return result;
}

Rigid3d SlamSystem::InWorld(const Rigid3d& T_odom_lidar) const {
  return map_.keyframes.empty() ? T_odom_lidar : ToWorld(map_.keyframes.back(), T_odom_lidar);
}

ImageFeatures SlamSystem::DescribeImage(const SensorFrame& frame,
                                        const PreprocessedFrame& preprocessed) const {
  if (!options_.loops.enabled || !options_.loops.use_visual) return {};
  return preprocessor_.Describe(frame, preprocessed, last_motion_);
}

void SlamSystem::Advance(const FoundPose& found, FrameResult* result) {
  // Across frames without data a pose continues the last one that was measured.
  const bool follows_skipped =
      IsMeasured(result->status) && !found.bridge && known_.path + 1 < path_.size();
  if (follows_skipped) {
    path_m_ = known_.path_m;
    uncertainty_ = known_.uncertainty;
  }
  Rigid3d T_odom_prev;
  if (!path_.empty()) {
    T_odom_prev = path_[follows_skipped ? known_.path : path_.size() - 1].T_odom_lidar;
  }
  const Rigid3d T_prev_cur = found.tracked.Motion(T_odom_prev);
  last_motion_ = {T_prev_cur, found.tracked.start.duration_s()};
  const bool is_lost = result->status == FrameStatus::kLost;
  const int lost_scan = found.tracked.cloud.planes.points.empty() ? 0 : 1;
  if (IsMeasured(result->status)) lost_scans_ = 0;
  if (is_lost) lost_scans_ += lost_scan;
  path_m_ += T_prev_cur.t().norm();
  if (found.bridge) {
    // Both ends were measured against one map: what lies between says nothing of their relation.
    uncertainty_ = known_.uncertainty;
    AddUncertainty(found, found.bridge->T_odom_known.Inverse() * result->T_odom_lidar, result);
    LayBridge(*found.bridge, result->T_odom_lidar);
  } else {
    AddUncertainty(found, T_prev_cur, result);
    if (follows_skipped) MoveBetween(T_odom_prev, result->T_odom_lidar);
  }
}

void SlamSystem::AddUncertainty(const FoundPose& found, const Rigid3d& T_prev_cur,
                                FrameResult* result) {
  if (result->status == FrameStatus::kFirst) return;
  const TrackedPose& tracked = found.tracked;
  PoseStep step{T_prev_cur, tracked.odometry.covariance, tracked.map_step.estimate.information,
                Matrix6d::Zero()};
  step.beyond_covariance.block<2, 2>(3, 3) = found.beyond_covariance_m2;
  result->step_covariance = uncertainty_.Add(step);
  result->pose_covariance = uncertainty_.SinceFirst();
  result->noise_covariance = uncertainty_.AgainstMap();
  result->walk_covariance = uncertainty_.Walk();
}

void SlamSystem::LayBridge(const Bridge& bridge, const Rigid3d& T_odom_lidar) {
  MoveBetween(bridge.T_odom_known, T_odom_lidar);
  path_m_ = known_.path_m + (bridge.T_odom_known.Inverse() * T_odom_lidar).t().norm();
}

// Along one screw motion from the last known pose to the one of this frame.
void SlamSystem::MoveBetween(const Rigid3d& T_odom_known, const Rigid3d& T_odom_lidar) {
  const Rigid3d T_known_cur = T_odom_known.Inverse() * T_odom_lidar;
  const size_t steps = path_.size() - known_.path;
  for (size_t i = known_.path + 1; i < path_.size(); ++i) {
    const double share = static_cast<double>(i - known_.path) / static_cast<double>(steps);
    path_[i].T_odom_lidar = T_odom_known * Scale(share, T_known_cur);
  }
}

void SlamSystem::Describe(const PreprocessedFrame& frame, const FoundPose& found,
                          FrameResult* result) const {
  result->tracking = frame.tracks.status;
  result->tracks = static_cast<int>(frame.tracks.tracks.size());
  result->tracks_with_depth = CountDepths(frame.depths);
  result->T_odom_lidar = found.tracked.T_odom_lidar;
  result->status = found.status;
  result->odometry = found.tracked.odometry;
  result->map_step = found.tracked.map_step;
  result->map_step.planes.clear();
  result->misfit = found.tracked.fit.mean;
  result->usual_misfit = found.usual_misfit;
  result->misfit_points = found.tracked.fit.judged;
  result->origin = found.origin;
  result->hypotheses = found.hypotheses;
}

void SlamSystem::ReplaceLastCloud(KeyframeCloud cloud, const Executor& executor) {
  if (map_.keyframes.empty() || map_.keyframes.back().frame != finder_.last_frame().id) return;
  const int index = map_.keyframes.back().id.index;
  KeyframePayload payload = *map_.store->Get(index);
  payload.cloud = std::move(cloud);
  map_.store->Put(index, std::make_shared<const KeyframePayload>(std::move(payload)));
  local_map_ = LocalMap(options_.mapping.local_map);
  local_map_.Add(MemberOf(map_, map_.keyframes.size() - 1), executor);
}

void SlamSystem::CalibrateBeams(const FoundPose& found, const PreprocessedFrame& frame) {
  const std::vector<uint32_t>& source = found.tracked.map_step_source;
  if (source.empty()) return;
  std::vector<uint16_t> rings;
  rings.reserve(source.size());
  for (const uint32_t i : source) rings.push_back(frame.features.less_flat[i].ring);
  beams_.Add(found.tracked.map_step.planes, rings, found.tracked.T_odom_lidar,
             options_.mapping.scan_to_map.kernel_sigmas);
}

bool SlamSystem::IsDueKeyframe(const PreprocessedFrame& frame, const FrameResult& result) const {
  if (!frame.has_scan || !IsMeasured(result.status)) return false;
  const Rigid3d T_lastkeyframe_cur =
      map_.keyframes.empty() ? Rigid3d()
                             : map_.keyframes.back().T_odom_lidar.Inverse() * result.T_odom_lidar;
  return IsKeyframe(T_lastkeyframe_cur, map_.keyframes.size(), options_.mapping.keyframes);
}

void SlamSystem::Restart(const FrameResult& result, const Executor& executor) {
  local_map_ = LocalMap(options_.mapping.local_map);
  uncertainty_.BeginMap();
  AddKeyframe(result, {last_cloud_, {}}, executor);
  if (loop_closer_ != nullptr) CloseLoops(executor);
  known_ = {path_.size() - 1, path_m_, uncertainty_};
  finder_.Restart();
  ForgetViews();
  lost_scans_ = 0;
}

void SlamSystem::AddKeyframe(const FrameResult& result, KeyframePayload payload,
                             const Executor& executor) {
  Keyframe keyframe;
  keyframe.id = {0, static_cast<int32_t>(map_.keyframes.size())};
  keyframe.frame = result.id;
  keyframe.stamp = stamp_;
  keyframe.path_m = path_m_;
  keyframe.T_odom_lidar = result.T_odom_lidar;
  keyframe.T_world_lidar = result.T_odom_lidar;
  if (!map_.keyframes.empty()) {
    const Keyframe& previous = map_.keyframes.back();
    keyframe.T_prev_cur = previous.T_odom_lidar.Inverse() * result.T_odom_lidar;
    keyframe.covariance = uncertainty_.SinceKeyframe();
    keyframe.T_world_lidar = previous.T_world_lidar * keyframe.T_prev_cur;
  }
  uncertainty_.BeginKeyframe();
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
    EndLoopSearch(error);
  }
}

void SlamSystem::EndLoopSearch(const std::exception& error) {
  if (!loop_fault_.empty()) return;
  loop_fault_ = error.what();
  loop_search_broke_ = dynamic_cast<const InputError*>(&error) == nullptr;
}

std::vector<int> SlamSystem::ApplyNext() {
  if (loop_thread_.pending() == 0) return {};
  try {
    const LoopUpdate update = loop_thread_.Take();
    if (!loop_fault_.empty()) return {};  // of work given before the fault was known
    Apply(update);
    return update.connected;
  } catch (const std::exception& error) {
    EndLoopSearch(error);
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

void SlamSystem::Finish(const GoOn& go_on) {
  if (loop_closer_ == nullptr) return;
  while (loop_thread_.pending() > 0) ApplyNext();
  if (!loop_fault_.empty()) return;
  loop_thread_.Give([closer = loop_closer_, go_on] { return closer->LookAgain(go_on); });
  ApplyNext();
  if (!loop_fault_.empty()) return;
  loop_thread_.Give([closer = loop_closer_] { return closer->Polish(); });
  ApplyNext();
}

}  // namespace tvl
