// Every option of the system, nested as its parts are.
#pragma once

#include "tvl/depth/depth_options.h"
#include "tvl/lidar/feature_extraction.h"
#include "tvl/lidar/planar_points.h"
#include "tvl/lidar/segmentation.h"
#include "tvl/map/keyframe_store.h"
#include "tvl/mapping/keyframe_selector.h"
#include "tvl/mapping/local_map.h"
#include "tvl/mapping/map_fit.h"
#include "tvl/mapping/moving_tracks.h"
#include "tvl/mapping/scan_to_map.h"
#include "tvl/odometry/visual_lidar_odometry.h"
#include "tvl/registration/beam_calibration.h"
#include "tvl/registration/extrinsic_calibration.h"
#include "tvl/slam/frame_clock.h"
#include "tvl/slam/health_options.h"
#include "tvl/slam/loop_closer.h"
#include "tvl/slam/motion_model.h"
#include "tvl/slam/pose_search_options.h"
#include "tvl/slam/pose_uncertainty.h"
#include "tvl/slam/traffic_monitor.h"
#include "tvl/vision/feature_tracker.h"
#include "tvl/vision/image_feature_extractor.h"

namespace tvl {

struct PreprocessingOptions {
  FeatureTrackerOptions vision;
  ImageFeatureOptions loop_features;  // of keyframes
  SegmentationOptions segmentation;
  LaserFeatureOptions features;
  PlanarPointOptions planar_points;  // in place of `features` for scans without rings
  DepthOptions depth;
  // With fewer tracks on the road than three quarters of this, so many are looked for there, beside
  // the others. In a jam the lettering on lorries has the stronger corners, and only the road
  // stands still.
  int road_features = 40;
  // The extrinsics were estimated from points without the profile's vertical correction, and have
  // absorbed it where the camera looks: true of KITTI's own (measured on drive 2011_09_26_0052),
  // not of KITTI-360's nor of a simulator's. See docs/decisions.md.
  bool calibrated_on_stored_points = false;
};

struct MappingOptions {
  // The map step runs on every interval-th frame; 5 gives the paper's 2 Hz.
  int interval = 1;
  BeamCalibrationOptions beams;
  KeyframeOptions keyframes;
  KeyframeStoreOptions store;
  LocalMapOptions local_map;
  LandmarkOptions landmarks;
  MovingTrackOptions moving_tracks;
  ScanToMapOptions scan_to_map;
  MapFitOptions fit;
};

struct SlamOptions {
  PreprocessingOptions preprocessing;
  FrameClockOptions clock;
  MotionModelOptions motion;
  OdometryOptions odometry;
  MappingOptions mapping;
  PoseSearchOptions search;
  HealthOptions health;
  TrafficOptions traffic;
  ExtrinsicCalibrationOptions extrinsics;
  PoseUncertaintyOptions uncertainty;
  LoopOptions loops;
  bool use_camera = true;
  void Check() const;
};

}  // namespace tvl
