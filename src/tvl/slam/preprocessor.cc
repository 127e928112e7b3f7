#include "tvl/slam/preprocessor.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/depth/depth_association.h"
#include "tvl/lidar/deskew.h"
#include "tvl/lidar/planar_points.h"
#include "tvl/vision/pixel_prediction.h"

namespace tvl {
namespace {

constexpr float kNearest_m = 0.5f;  // nearer the projection flies off with any error
// Beyond, a pixel spans half a metre of road.
constexpr float kFarthestRoad_m = 25.0f;

RoadView ViewRoad(const SegmentedScan& scan, const Calibration& calibration) {
  constexpr size_t kEvery = 2;  // point of a ring: three pixels apart with an HDL-64E
  const Eigen::Matrix3f R = calibration.T_cam_lidar.R().cast<float>();
  const Eigen::Vector3f t = calibration.T_cam_lidar.t().cast<float>();
  RoadView view;
  for (size_t i = 0; i < scan.size(); i += kEvery) {
    const Eigen::Vector3f p_cam = R * scan.points[i] + t;
    // Far to the side nothing is in the image.
    if (p_cam.z() < std::max(kNearest_m, std::abs(p_cam.x()))) continue;
    if (p_cam.z() > kFarthestRoad_m) continue;
    const Eigen::Vector2d ray = p_cam.hnormalized().cast<double>();
    (scan.label[i] == kLabelGround ? view.road_px : view.standing_px)
        .push_back(calibration.camera.Project(ray).cast<float>());
  }
  return view;
}

}  // namespace

Preprocessor::Preprocessor(const SensorSetup& setup, Deskew deskew,
                           const PreprocessingOptions& options, bool use_camera)
    : setup_(setup),
      deskew_(deskew),
      options_(options),
      use_camera_(use_camera),
      tracker_(options.vision),
      extractor_(options.loop_features) {}

PreprocessedFrame Preprocessor::Process(const SensorFrame& frame, const PredictedMotion& predicted,
                                        const BeamOffsets& beams, const Executor& executor,
                                        StageTimes* times, std::vector<FrameFault>* faults) {
  PreprocessedFrame out;
  out.id = frame.id;
  out.stamp = frame.stamp;
  executor.Invoke({[&] { ProcessScan(frame, beams, &out, times, faults); },
                   [&] { ProcessImage(frame, predicted, &out, times); }});
  const Stopwatch watch;
  out.depths = FindDepths(out.tracks, out, predicted);
  AddRoadTracks(predicted, &out);
  times->depth_ms += watch.ElapsedMs();
  previous_tracks_ = out.tracks;
  previous_depths_ = out.depths;
  return out;
}

void Preprocessor::ProcessImage(const SensorFrame& frame, const PredictedMotion& predicted,
                                PreprocessedFrame* out, StageTimes* times) {
  if (!use_camera_ || !setup_.has_camera) return;
  const Stopwatch watch;
  const Rigid3d& T_cam_lidar = setup_.calibration.T_cam_lidar;
  const Rigid3d T_cur_prev_cam =
      T_cam_lidar * predicted.T_prev_cur.Inverse() * T_cam_lidar.Inverse();
  const PixelPredictions expected =
      PredictPixels(previous_tracks_, previous_depths_, T_cur_prev_cam, setup_.calibration.camera);
  out->tracks = tracker_.Track(frame.image, setup_.calibration.camera, expected);
  out->has_image = out->tracks.status != TrackingStatus::kNoImage;
  times->vision_ms += watch.ElapsedMs();
}

void Preprocessor::AddRoadTracks(const PredictedMotion& motion, PreprocessedFrame* frame) {
  const auto on_road =
      std::count_if(frame->depths.begin(), frame->depths.end(),
                    [](const VisualDepth& depth) { return depth.label == kLabelGround; });
  if (!frame->has_image || !frame->has_scan || 4 * on_road > 3 * options_.road_features) return;
  const Camera& camera = setup_.calibration.camera;
  FeatureTracks added;
  added.tracks = tracker_.AddOnRoad(ViewRoad(frame->scan, setup_.calibration),
                                    options_.road_features - static_cast<int>(on_road), camera);
  const VisualDepths depths = FindDepths(added, *frame, motion);
  frame->tracks.added += static_cast<int>(added.tracks.size());
  frame->tracks.tracks.insert(frame->tracks.tracks.end(), added.tracks.begin(), added.tracks.end());
  frame->depths.insert(frame->depths.end(), depths.begin(), depths.end());
}

void Preprocessor::ProcessScan(const SensorFrame& frame, const BeamOffsets& beams,
                               PreprocessedFrame* out, StageTimes* times,
                               std::vector<FrameFault>* faults) {
  if (frame.scan == nullptr) return;
  Stopwatch watch;
  try {
    out->scan = SegmentScan(*frame.scan, setup_.lidar, deskew_, options_.segmentation, &workspace_);
  } catch (const InputError& error) {
    faults->push_back(
        {FrameFault::Kind::kOddScan, "frame " + std::to_string(frame.id) + ": " + error.what()});
    return;
  }
  ApplyBeamOffsets(beams, out->scan.ring, &out->scan.points);
  times->segmentation_ms += watch.LapMs();
  out->features = setup_.lidar.rows_are_beams
                      ? ExtractLaserFeatures(out->scan, setup_.lidar, options_.features)
                      : FindPlanarPoints(out->scan, options_.planar_points);
  out->has_scan = !out->features.less_flat.empty();
  times->features_ms += watch.ElapsedMs();
}

std::vector<Eigen::Vector3f> Preprocessor::PointsAtStamp(const PreprocessedFrame& frame,
                                                         const PredictedMotion& motion) const {
  if (deskew_ == Deskew::kNone) return frame.scan.points;
  return DeskewPoints(frame.scan.points, frame.scan.time_offset_s, motion.T_prev_cur,
                      motion.period_s);
}

EdgeProfiles Preprocessor::FindEdges(const PreprocessedFrame& preprocessed,
                                     const PredictedMotion& motion, int max_edges) const {
  if (!preprocessed.has_scan || !preprocessed.has_image) return {};
  return FindEdgeProfiles(tracker_.grey(), preprocessed.scan, PointsAtStamp(preprocessed, motion),
                          setup_.calibration.camera, setup_.calibration.T_cam_lidar,
                          motion.Velocity_lidar(), max_edges);
}

VisualDepths Preprocessor::FindDepths(const FeatureTracks& tracks, const PreprocessedFrame& frame,
                                      const PredictedMotion& motion) const {
  if (!frame.has_scan || tracks.tracks.empty()) return VisualDepths(tracks.tracks.size());
  return AssociateDepth(tracks, PointsAtStamp(frame, motion), frame.scan, setup_.calibration.camera,
                        setup_.calibration.T_cam_lidar, setup_.lidar, options_.depth);
}

ImageFeatures Preprocessor::Describe(const SensorFrame& frame,
                                     const PreprocessedFrame& preprocessed,
                                     const PredictedMotion& motion) const {
  if (!preprocessed.has_image) return {};
  ImageFeatures features = extractor_.Extract(frame.image, setup_.calibration.camera);
  FeatureTracks rays;
  for (const Eigen::Vector2f& ray : features.ray_cam) {
    rays.tracks.push_back(
        {0, 1, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), ray.cast<double>()});
  }
  const VisualDepths depths = FindDepths(rays, preprocessed, motion);
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].status == DepthStatus::kOk) {
      features.depth_m[i] = static_cast<float>(depths[i].depth_m);
    }
  }
  return features;
}

}  // namespace tvl
