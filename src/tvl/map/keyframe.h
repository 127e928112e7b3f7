// What is kept of a keyframe (paper 6.1, Eq. 9): an immutable payload, and poses beside it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/base/ids.h"
#include "tvl/base/time.h"
#include "tvl/frame/image_features.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// Points compensated to the keyframe's stamp, in its lidar frame, with intensity 0..1.
struct FeatureCloud {
  std::vector<Eigen::Vector3f> points;  // p_lidar, m
  std::vector<float> intensity;         // as long as points
};

// F_ls and F_lf of one keyframe, 16 bytes a point.
struct KeyframeCloud {
  FeatureCloud edges;   // F_ls
  FeatureCloud planes;  // F_lf
};

// What a keyframe saw. About 0.3 MB, kept in a KeyframeStore.
struct KeyframePayload {
  KeyframeCloud cloud;
  ImageFeatures image;  // empty without a camera, or if loops are not sought by it
};

// The odometry frame never jumps: it is the world as the odometry alone sees it, and drifts. What
// loops correct is T_world_lidar. Payloads lie in the map's store under `id.index`.
struct Keyframe {
  KeyframeId id;
  FrameId frame = 0;
  Timestamp stamp;      // the frame's; runs on, and never back, where the input's clock does not
  double path_m = 0.0;  // length driven up to here
  Rigid3d T_odom_lidar;
  Rigid3d T_world_lidar;
  // The odometry's motion since the keyframe before, and its covariance (right perturbation,
  // [rotation, translation]); identity and zero for the first.
  Rigid3d T_prev_cur;
  Matrix6d covariance = Matrix6d::Zero();
};

}  // namespace tvl
