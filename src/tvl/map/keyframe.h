// What is kept of a keyframe (paper 6.1, Eq. 9). Payloads are immutable; poses live beside them.
#pragma once

#include <Eigen/Core>
#include <memory>
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
  ImageFeatures image;  // empty without a camera
};

struct Keyframe {
  KeyframeId id;
  FrameId frame = 0;
  Timestamp stamp;
  Rigid3d T_world_lidar;
  double path_m = 0.0;  // length driven up to here
  std::shared_ptr<const KeyframeCloud> cloud;
};

// Sole owner of the keyframes, in the order they were made. No rule ties the world's origin to the
// first of them.
struct Map {
  std::vector<Keyframe> keyframes;
};

}  // namespace tvl
