// Visual residuals between consecutive images (paper 5.1): by track id, in the form the known
// depths allow.
#pragma once

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/registration/visual_terms.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct VisualMatchOptions {
  // Of the flow between two images. On KITTI and KITTI-360 it leaves its epipolar line by 0.12 to
  // 0.34 px (1.48 x the median).
  double sigma_px = 0.35;
  double max_relative_sigma = 0.15;  // of a depth: vaguer depths count as none
  double min_baseline_m = 0.15;      // shorter: epipolar planes are undefined
  void Check() const;
};

// Features of one image with what is known of their depth.
struct VisualFeatures {
  FeatureTracks tracks;
  VisualDepths depths;  // one a track
};

// Depth at k: reproject into k+1; depth at k+1 only: the inverse; none: epipolar. Weights follow
// from T_prev_cur, a guess. ReprojectionMatch::source is the index of the current track.
VisualMatches MatchVisual(const VisualFeatures& previous, const VisualFeatures& current,
                          const Calibration& calibration, const Rigid3d& T_prev_cur,
                          const VisualMatchOptions& options);

}  // namespace tvl
