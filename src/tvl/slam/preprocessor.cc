#include "tvl/slam/preprocessor.h"

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/depth/depth_association.h"
#include "tvl/lidar/deskew.h"
#include "tvl/vision/pixel_prediction.h"

namespace tvl {

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
  out->features = ExtractLaserFeatures(out->scan, setup_.lidar, options_.features);
  out->has_scan = !out->features.less_flat.empty();
  times->features_ms += watch.ElapsedMs();
}

VisualDepths Preprocessor::FindDepths(const FeatureTracks& tracks, const PreprocessedFrame& frame,
                                      const PredictedMotion& motion) const {
  if (!frame.has_scan || tracks.tracks.empty()) return VisualDepths(tracks.tracks.size());
  const std::vector<Eigen::Vector3f> points =
      deskew_ == Deskew::kNone ? frame.scan.points
                               : DeskewPoints(frame.scan.points, frame.scan.time_offset_s,
                                              motion.T_prev_cur, motion.period_s);
  return AssociateDepth(tracks, points, frame.scan, setup_.calibration.camera,
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
