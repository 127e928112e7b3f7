// Depth of visual features from the lidar; what depth association hands on (paper 4.4).
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/frame/segmented_scan.h"

namespace tvl {

enum class DepthStatus : uint8_t {
  kOk,
  kNoPoints,       // too few lidar points in the neighbourhood
  kOneRing,        // all on one laser line: no plane
  kSmallTriangle,  // area gate
  kSpread,         // depths differ by more than a surface can: foreground not separable
  kGrazing,        // ray nearly inside the plane
  kBehind,         // plane behind the camera (the trap of Eq. 2)
  kTooFar,
};

// One entry a track of the frame's FeatureTracks, in the same order.
struct VisualDepth {
  DepthStatus status = DepthStatus::kNoPoints;
  double depth_m = 0.0;  // z in the camera frame; valid for kOk
  double sigma_m = 0.0;  // standard deviation along the ray, as depth
  // SegmentedScan::label of the foreground that the track lies on; kLabelOutlier: none is known.
  int32_t label = kLabelOutlier;
};

using VisualDepths = std::vector<VisualDepth>;

}  // namespace tvl
