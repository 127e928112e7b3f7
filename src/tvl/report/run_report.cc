#include "tvl/report/run_report.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "tvl/base/units.h"
#include "tvl/report/calibration_text.h"
#include "tvl/report/loop_report.h"

namespace tvl {
namespace {

using nlohmann::json;

struct Stage {
  const char* name;
  double (*ms)(const StageTimes&);
};

// In the order of the pipeline; the last four are the paper's Table 2.
constexpr Stage kStages[] = {
    {"vision", [](const StageTimes& t) { return t.vision_ms; }},
    {"segmentation", [](const StageTimes& t) { return t.segmentation_ms; }},
    {"laser_features", [](const StageTimes& t) { return t.features_ms; }},
    {"depth", [](const StageTimes& t) { return t.depth_ms; }},
    {"odometry_step", [](const StageTimes& t) { return t.odometry_ms; }},
    {"map_step", [](const StageTimes& t) { return t.map_step_ms; }},
    {"map_update", [](const StageTimes& t) { return t.map_update_ms; }},
    {"loops", [](const StageTimes& t) { return t.loops_ms; }},
    {"preprocessing",
     [](const StageTimes& t) {
       return t.vision_ms + t.segmentation_ms + t.features_ms + t.depth_ms;
     }},
    {"odometry", [](const StageTimes& t) { return t.odometry_ms; }},
    {"mapping", [](const StageTimes& t) { return t.map_step_ms + t.map_update_ms; }},
    {"total", [](const StageTimes& t) { return t.total_ms; }},
};

struct Percentiles {
  double mean = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
};

Percentiles PercentilesOf(const RunResult& result, const Stage& stage) {
  std::vector<double> values;
  for (const FrameResult& frame : result.frames) values.push_back(stage.ms(frame.times));
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<size_t>(
        std::llround(share * static_cast<double>(values.size() - 1)))];
  };
  double sum = 0.0;
  for (const double v : values) sum += v;
  return {sum / static_cast<double>(values.size()), at(0.5), at(0.95), at(0.99), values.back()};
}

json Timing(const RunResult& result) {
  json timing;
  for (const Stage& stage : kStages) {
    const Percentiles p = PercentilesOf(result, stage);
    timing[stage.name] = {{"mean_ms", p.mean},
                          {"p50_ms", p.p50},
                          {"p95_ms", p.p95},
                          {"p99_ms", p.p99},
                          {"max_ms", p.max}};
  }
  return timing;
}

json Evidence(const MotionEstimate& estimate, double f_px) {
  const EstimateEvidence& e = estimate.evidence;
  return {{"status", ToString(estimate.status)},
          {"iterations", e.iterations},
          {"edges", e.edges},
          {"planes", e.planes},
          {"visual", e.visual},
          {"visual_offered", e.visual_offered},
          {"edge_rms_m", e.edge_rms_m},
          {"plane_rms_m", e.plane_rms_m},
          {"visual_rms_px", f_px * e.visual_rms}};
}

json Weak(const std::vector<WeakDirection>& directions) {
  json list = json::array();
  for (const WeakDirection& d : directions) {
    list.push_back({{"kind", d.is_rotation ? "rotation" : "translation"},
                    {"axis_lidar", {d.axis_lidar.x(), d.axis_lidar.y(), d.axis_lidar.z()}},
                    {"lidar_strength", d.lidar_strength},
                    {"camera_strength", d.camera_strength},
                    {"held_by", d.camera_strength > d.lidar_strength ? "camera" : "prediction"}});
  }
  return list;
}

const char* TrackingName(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kNoImage:
      return "no_image";
    case TrackingStatus::kFirst:
      return "first";
    case TrackingStatus::kTracked:
      return "tracked";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "unknown";
}

// Symmetric: the order is no matter.
std::vector<double> Elements(const Matrix6d& covariance) {
  return {covariance.data(), covariance.data() + covariance.size()};
}

json Frame(const FrameResult& frame, double f_px) {
  json faults = json::array();
  for (const FrameFault& fault : frame.faults) {
    faults.push_back({{"kind", ToString(fault.kind)}, {"message", fault.message}});
  }
  return {{"frame", frame.id},
          {"stamp_ns", frame.stamp.ns},
          {"status", ToString(frame.status)},
          {"keyframe", frame.is_keyframe},
          {"map_begins_anew", frame.map_begins_anew},
          {"tracking", TrackingName(frame.tracking)},
          {"tracks", frame.tracks},
          {"tracks_with_depth", frame.tracks_with_depth},
          {"tracks_moving", frame.tracks_moving},
          {"odometry", Evidence(frame.odometry, f_px)},
          {"map_step", Evidence(frame.map_step.estimate, f_px)},
          {"misfit", frame.misfit},
          {"usual_misfit", frame.usual_misfit},
          {"misfit_points", frame.misfit_points},
          {"origin", ToString(frame.origin)},
          {"hypotheses", frame.hypotheses},
          {"translation_ratio", frame.map_step.translation_ratio},
          {"rotation_ratio", frame.map_step.rotation_ratio},
          {"weak", Weak(frame.map_step.estimate.weak)},
          {"step_covariance", Elements(frame.step_covariance)},
          {"pose_covariance", Elements(frame.pose_covariance)},
          {"noise_covariance", Elements(frame.noise_covariance)},
          {"walk_covariance", Elements(frame.walk_covariance)},
          {"faults", faults},
          {"total_ms", frame.times.total_ms}};
}

// Every expected failure and how often it happened.
json Counts(const RunResult& result) {
  std::map<std::string, int> counts = {{"frames", 0},
                                       {"keyframes", 0},
                                       {"predicted", 0},
                                       {"tracking_lost", 0},
                                       {"no_image", 0},
                                       {"odometry_not_converged", 0},
                                       {"map_not_converged", 0},
                                       {"weak_translation", 0},
                                       {"weak_rotation", 0}};
  for (const FrameResult& frame : result.frames) {
    ++counts["frames"];
    counts["keyframes"] += frame.is_keyframe;
    counts["predicted"] += frame.status == FrameStatus::kPredicted;
    counts["tracking_lost"] += frame.tracking == TrackingStatus::kLost;
    counts["no_image"] += frame.tracking == TrackingStatus::kNoImage;
    counts["odometry_not_converged"] += frame.odometry.status == EstimateStatus::kNotConverged;
    counts["map_not_converged"] += frame.map_step.estimate.status == EstimateStatus::kNotConverged;
    bool translation = false, rotation = false;
    for (const WeakDirection& d : frame.map_step.estimate.weak) {
      (d.is_rotation ? rotation : translation) = true;
    }
    counts["weak_translation"] += translation;
    counts["weak_rotation"] += rotation;
    for (const FrameFault& fault : frame.faults)
      ++counts[std::string("fault_") + ToString(fault.kind)];
  }
  return counts;
}

json DeskewReport(const DeskewDecision& decision) {
  return {{"deskew", ToString(decision.deskew)},
          {"verdict", ToString(decision.verdict)},
          {"reason", decision.reason},
          {"informative_frames", decision.informative},
          {"residual_sq_m2",
           {{"none", decision.residual_sq_m2[0]},
            {"cw", decision.residual_sq_m2[1]},
            {"ccw", decision.residual_sq_m2[2]}}}};
}

json AnglesDeg(const Eigen::Vector3d& angles_rad) {
  return {RadToDeg(angles_rad.x()), RadToDeg(angles_rad.y()), RadToDeg(angles_rad.z())};
}

// In milliseconds and metres.
json OffsetReport(const CameraOffsetEstimate& offset) {
  const auto vector = [](const Eigen::Vector3d& v) { return json{v.x(), v.y(), v.z()}; };
  return {{"images", offset.images},
          {"delay_ms", 1e3 * offset.delay_s},
          {"delay_sigma_ms", 1e3 * offset.delay_sigma_s},
          {"applied_delay_ms", 1e3 * offset.applied_delay_s},
          {"translation_m", vector(offset.translation_m)},
          {"translation_sigma_m", vector(offset.translation_sigma_m)},
          {"words", DelayText(offset)}};
}

json ExtrinsicsReport(const ExtrinsicEstimate& estimate) {
  return {{"rotation_deg", AnglesDeg(estimate.rotation_rad)},
          {"sigma_deg", AnglesDeg(estimate.sigma_rad)},
          {"applied_deg", AnglesDeg(estimate.applied_rad)},
          {"windows", estimate.windows},
          {"edge_images", estimate.edge_images},
          {"offset", OffsetReport(estimate.offset)}};
}

// YAML's scalars are text: numbers and booleans get their type back.
json ToJson(const YAML::Node& node) {
  json out;
  if (node.IsMap()) {
    out = json::object();
    for (const auto& entry : node) out[entry.first.as<std::string>()] = ToJson(entry.second);
  } else if (node.IsSequence()) {
    out = json::array();
    for (const auto& entry : node) out.push_back(ToJson(entry));
  } else if (node.IsScalar()) {
    const json parsed = json::parse(node.as<std::string>(), nullptr, false);
    out = parsed.is_discarded() ? json(node.as<std::string>()) : parsed;
  }
  return out;
}

}  // namespace

json MakeRunReport(const RunResult& result, const RunContext& context) {
  json frames = json::array();
  for (const FrameResult& frame : result.frames)
    frames.push_back(Frame(frame, context.setup.calibration.camera.fx_px));
  json report = {{"program", {{"name", "tvl"}, {"version", context.version}}},
                 {"input", context.input},
                 {"lidar_profile", context.setup.lidar.name},
                 {"camera", context.setup.has_camera},
                 {"warnings", context.setup.warnings},
                 {"recognised", context.setup.notes},
                 {"threads", context.threads},
                 {"complete", !result.stopped},
                 {"options", ToJson(YAML::Load(context.options_yaml))},
                 {"deskew", DeskewReport(result.deskew)},
                 {"extrinsics", ExtrinsicsReport(result.extrinsics)},
                 {"counts", Counts(result)},
                 {"timing", Timing(result)},
                 {"wall_s", context.wall_s},
                 {"peak_memory_mib", context.peak_memory_mib},
                 {"frames", frames}};
  if (!result.loops.times.empty()) report["loops"] = LoopsToJson(result.loops, context.truth);
  if (!result.loop_fault.empty()) {
    report["loops"]["fault"] = result.loop_fault;
    report["loops"]["is_defect"] = result.loop_search_broke;
  }
  report["keyframe_store"] = {{"memory_bytes", result.map.store->memory_bytes()},
                              {"file_bytes", result.map.store->file_bytes()}};
  if (context.setup.seed) report["seed"] = *context.setup.seed;
  return report;
}

std::string ExtrinsicsText(const ExtrinsicEstimate& estimate) {
  // By axis of the camera: a positive rotation of the calibration means that the camera points ...
  struct Turn {
    const char *positive, *negative;
  };
  constexpr Turn kTurns[] = {{"lower", "higher"}, {"further left", "further right"}, {"", ""}};
  constexpr double kNotable_deg = 1.0;
  constexpr double kLargeDelay_s = 0.015;  // 0.2 m at 50 km/h
  std::ostringstream out;
  const CameraOffsetEstimate& offset = estimate.offset;
  if (IsDelayObserved(offset) && offset.applied_delay_s != 0.0) out << DelayText(offset) << "\n";
  if (IsDelayObserved(offset) && std::abs(offset.delay_s) > kLargeDelay_s) {
    out << "warning: that is a long time for a camera: check which instant its stamps mean\n";
  }
  if (estimate.applied_rad.isZero(0.0)) return out.str();
  out << std::fixed << std::setprecision(2) << "the camera points";
  for (int i = 0; i < 2; ++i) {
    const double angle_deg = RadToDeg(estimate.rotation_rad[i]);
    out << (i == 0 ? " " : " and ") << std::abs(angle_deg) << " deg "
        << (angle_deg > 0.0 ? kTurns[i].positive : kTurns[i].negative);
  }
  out << ", turned by " << RadToDeg(estimate.rotation_rad.z())
      << " deg about its axis, against the calibration (sigma " << RadToDeg(estimate.sigma_rad.x())
      << ", " << RadToDeg(estimate.sigma_rad.y()) << ", " << RadToDeg(estimate.sigma_rad.z())
      << " deg): corrected\n";
  if (RadToDeg(estimate.rotation_rad.norm()) > kNotable_deg) {
    out << "warning: that is far for a calibration: check calib.txt and the size of the images\n";
  }
  return out.str();
}

std::string TimingTable(const RunResult& result) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(1);
  out << "  ms a frame          p50     p95     p99    mean\n";
  for (const Stage& stage : kStages) {
    const Percentiles p = PercentilesOf(result, stage);
    out << "  " << std::left << std::setw(16) << stage.name << std::right << std::setw(7) << p.p50
        << " " << std::setw(7) << p.p95 << " " << std::setw(7) << p.p99 << " " << std::setw(7)
        << p.mean << "\n";
  }
  return out.str();
}

}  // namespace tvl
