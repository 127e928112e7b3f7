// rig.yaml: what is known of the sensors of a recording and is not in it.
//
//   lidar:                         # optional; the keys of a profile, see profile.h
//     name: OS1-64
//     ...
//   camera:                        # optional; intrinsics
//     intrinsics_px: [fx, fy, cx, cy]
//     size_px: [width, height]
//     distortion_model: plumb_bob  # plumb_bob (k1 k2 p1 p2 k3), rational (k1 k2 p1 p2 k3 k4 k5
//     k6),
//                                  # equidistant (k1 k2 k3 k4)
//     distortion: [0, 0, 0, 0, 0]  # left out: rectified images
//   T_cam_lidar:                   # optional; lidar to camera, 3 x 4, row by row: camera x right,
//     [r11, r12, ..., t3]          # y down, z forward; lidar x forward, y left, z up; metres
//   lidar_topic: /points           # optional; bags with several topics
//   image_topic: /camera/image
//
// What the file does not say is taken from the recording. Unknown keys are errors.
#pragma once

#include <optional>
#include <string>

#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

struct Rig {
  std::optional<LidarModel> lidar;
  std::optional<Camera> camera;
  std::optional<Rigid3d> T_cam_lidar;
  std::string lidar_topic, image_topic;
};

// Throws InputError naming the file, line and key.
Rig LoadRig(const std::string& path);
Rig ParseRig(const std::string& yaml, const std::string& source);

// The text of a rig.yaml, with all digits.
std::string DumpRig(const Rig& rig);

}  // namespace tvl
