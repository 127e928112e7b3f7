#include "tvl/slam/slam_options.h"

#include "tvl/base/check.h"

namespace tvl {

void SlamOptions::Check() const {
  preprocessing.vision.Check();
  preprocessing.loop_features.Check();
  preprocessing.segmentation.Check();
  preprocessing.features.Check();
  preprocessing.planar_points.Check();
  preprocessing.depth.Check();
  TVL_CHECK_INPUT(preprocessing.road_features >= 0)
      << "preprocessing.road_features: must not be negative";
  clock.Check();
  motion.Check();
  odometry.Check();
  TVL_CHECK_INPUT(mapping.interval >= 1) << "mapping.interval: must be at least 1";
  mapping.beams.Check();
  mapping.keyframes.Check();
  mapping.store.Check();
  mapping.local_map.Check();
  mapping.landmarks.Check();
  mapping.moving_tracks.Check();
  mapping.scan_to_map.Check();
  mapping.fit.Check();
  search.Check();
  health.Check();
  traffic.Check();
  extrinsics.Check();
  uncertainty.Check();
  loops.Check();
}

}  // namespace tvl
