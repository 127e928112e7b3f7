// Data preprocessing (paper section 4): what a raw frame looks like to the estimators.
#pragma once

#include "tvl/base/parallel.h"
#include "tvl/frame/image_features.h"
#include "tvl/frame/preprocessed_frame.h"
#include "tvl/registration/beam_calibration.h"
#include "tvl/registration/edge_alignment.h"
#include "tvl/sensor/dataset.h"
#include "tvl/slam/slam_options.h"
#include "tvl/slam/stage_times.h"

namespace tvl {

// The motion since the previous frame, as far as it can be foreseen.
struct PredictedMotion {
  Rigid3d T_prev_cur;
  double period_s = 0.1;  // between the two stamps

  Vector6d Velocity_lidar() const { return T_prev_cur.Log() / period_s; }
};

class Preprocessor {
 public:
  Preprocessor(const SensorSetup& setup, Deskew deskew, const PreprocessingOptions& options,
               bool use_camera);

  // Image and scan are worked on side by side where the executor has threads. Times are added to
  // `times`; `beams` corrects the points. A scan whose rings cannot be told is left out, for which
  // `faults` says why.
  PreprocessedFrame Process(const SensorFrame& frame, const PredictedMotion& predicted,
                            const BeamOffsets& beams, const Executor& executor, StageTimes* times,
                            std::vector<FrameFault>* faults);

  // From the next frame on.
  void SetCalibration(const Calibration& calibration) { setup_.calibration = calibration; }

  // What loop detection keeps of a keyframe's image, with depth where the lidar knows it (paper
  // 6.1). `motion` is the frame's, as estimated. Empty without a usable image.
  ImageFeatures Describe(const SensorFrame& frame, const PreprocessedFrame& preprocessed,
                         const PredictedMotion& motion) const;

  // Of the frame processed last: outlines of its scan in its image. `motion` is the frame's, as
  // estimated.
  EdgeProfiles FindEdges(const PreprocessedFrame& preprocessed, const PredictedMotion& motion,
                         int max_edges) const;

 private:
  // The scan's points at the time of the image.
  std::vector<Eigen::Vector3f> PointsAtStamp(const PreprocessedFrame& frame,
                                             const PredictedMotion& motion) const;
  void ProcessImage(const SensorFrame& frame, const PredictedMotion& predicted,
                    PreprocessedFrame* out, StageTimes* times);
  void ProcessScan(const SensorFrame& frame, const BeamOffsets& beams, PreprocessedFrame* out,
                   StageTimes* times, std::vector<FrameFault>* faults);
  // Looks for tracks on the road where there are few.
  void AddRoadTracks(const PredictedMotion& motion, PreprocessedFrame* frame);
  VisualDepths FindDepths(const FeatureTracks& tracks, const PreprocessedFrame& frame,
                          const PredictedMotion& motion) const;

  SensorSetup setup_;
  Deskew deskew_;
  PreprocessingOptions options_;
  bool use_camera_;
  FeatureTracker tracker_;
  ImageFeatureExtractor extractor_;
  SegmentationWorkspace workspace_;
  // Tracks and depths of the previous frame: where its features are to be looked for.
  FeatureTracks previous_tracks_;
  VisualDepths previous_depths_;
};

}  // namespace tvl
