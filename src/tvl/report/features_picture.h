// Laser and visual features of a frame (paper Fig. 5).
#pragma once

#include <opencv2/core/mat.hpp>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/laser_features.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

// Above, where there is an image: F_s (red), F_f (pink) and the visual features with depth F_v
// (yellow) on it, as Fig. 5a. Below, from above: F_ls (dark red) and F_lf (dim pink) as Fig. 5b,
// F_s, F_f and F_v on top. `depths` holds one entry a track. 8-bit BGR.
cv::Mat DrawFeatures(const cv::Mat& image, const LaserFeatures& features,
                     const FeatureTracks& tracks, const VisualDepths& depths,
                     const Calibration& calibration);

}  // namespace tvl
