// Poses that the camera has no part in, beside those that it has: each scan against a map of its
// own, made of scans placed by the lidar alone. What the camera is to be judged by must not follow
// it, and neither must the map.
#pragma once

#include <memory>
#include <optional>

#include "tvl/base/parallel.h"
#include "tvl/map/keyframe.h"
#include "tvl/mapping/keyframe_selector.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/local_map.h"
#include "tvl/mapping/scan_to_map.h"
#include "tvl/registration/hand_eye.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

class LidarOnlyPath {
 public:
  LidarOnlyPath(const Calibration& calibration, const ScanToMapOptions& scan_to_map,
                const LocalMapOptions& local_map, const KeyframeOptions& keyframes);

  // Takes a scan, compensated, thinned for the map step, and whole, and its pose as it is believed,
  // with the camera: from there it is matched. Returns its pose by the lidar alone, in a frame of
  // its own that begins with the first scan; nothing where the lidar alone finds none.
  std::optional<LidarPose> Add(const MapStepPoints& points,
                               const std::shared_ptr<const KeyframeCloud>& cloud,
                               const Rigid3d& T_odom_lidar, const Executor& executor);
  // The path begins anew with the next scan.
  void Forget();

 private:
  void AddToMap(const std::shared_ptr<const KeyframeCloud>& cloud, const Executor& executor);

  Calibration calibration_;
  ScanToMapOptions scan_to_map_;
  LocalMapOptions map_options_;
  KeyframeOptions keyframe_options_;
  LandmarkMap no_landmarks_;
  LocalMap map_;
  int keyframes_ = 0;
  double path_m_ = 0.0;
  Rigid3d T_own_keyframe_, T_own_last_, T_odom_last_;  // of the last keyframe, of the last scan
};

}  // namespace tvl
