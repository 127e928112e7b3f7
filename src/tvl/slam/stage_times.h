// Milliseconds a stage took in one frame.
#pragma once

namespace tvl {

struct StageTimes {
  double vision_ms = 0.0, segmentation_ms = 0.0, features_ms = 0.0, depth_ms = 0.0;
  double odometry_ms = 0.0, map_step_ms = 0.0, map_update_ms = 0.0;
  double loops_ms = 0.0;  // of the frame itself; the search runs beside it where there are threads
  double total_ms = 0.0;  // wall time of the frame; less than the sum where stages run side by side
};

}  // namespace tvl
