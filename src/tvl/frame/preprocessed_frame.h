// Everything preprocessing knows of one frame (paper section 4).
#pragma once

#include "tvl/base/ids.h"
#include "tvl/base/time.h"
#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/laser_features.h"
#include "tvl/frame/segmented_scan.h"
#include "tvl/frame/visual_depth.h"

namespace tvl {

struct PreprocessedFrame {
  FrameId id = 0;
  Timestamp stamp;
  bool has_scan = false;   // a usable scan was there
  bool has_image = false;  // a usable image was there
  FeatureTracks tracks;
  VisualDepths depths;  // one a track
  SegmentedScan scan;
  LaserFeatures features;
};

}  // namespace tvl
