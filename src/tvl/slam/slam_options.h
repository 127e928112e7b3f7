// Every option of the system, nested as its parts are.
#pragma once

#include "tvl/depth/depth_options.h"
#include "tvl/lidar/feature_extraction.h"
#include "tvl/lidar/segmentation.h"
#include "tvl/mapping/keyframe_selector.h"
#include "tvl/mapping/local_map.h"
#include "tvl/mapping/scan_to_map.h"
#include "tvl/odometry/visual_lidar_odometry.h"
#include "tvl/vision/feature_tracker.h"

namespace tvl {

struct PreprocessingOptions {
  FeatureTrackerOptions vision;
  SegmentationOptions segmentation;
  LaserFeatureOptions features;
  DepthOptions depth;
  // The vertical correction of the lidar's profile moves points by 2.6 px: whether the depth
  // association gets corrected points (measured on real images, see docs/decisions.md).
  bool correct_depth_points = true;
};

struct MappingOptions {
  // The map step runs on every interval-th frame; 5 gives the paper's 2 Hz.
  int interval = 1;
  KeyframeOptions keyframes;
  LocalMapOptions local_map;
  LandmarkOptions landmarks;
  ScanToMapOptions scan_to_map;
};

struct SlamOptions {
  PreprocessingOptions preprocessing;
  OdometryOptions odometry;
  MappingOptions mapping;
  bool use_camera = true;
  void Check() const;
};

}  // namespace tvl
