// Where the sensors sit.
#pragma once

#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct Calibration {
  Camera camera;         // the camera whose images are used (KITTI: any of 0..3)
  Rigid3d T_cam_lidar;   // into that camera
  Rigid3d T_cam0_lidar;  // into camera 0, the frame of KITTI poses; equal where there is one camera
  // What the rotation of T_cam_lidar may be off by, about the camera's axes, rad^2; zero: exact.
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();
};

// As seen from a frame's pose by an image that was taken `delay_s` after it, while the vehicle
// moves at `velocity_lidar`: rotation (rad/s) and translation (m/s), lidar axes. Camera 0 stays:
// poses are those of the frame.
inline Calibration Delayed(Calibration calibration, double delay_s,
                           const Vector6d& velocity_lidar) {
  calibration.T_cam_lidar = calibration.T_cam_lidar * Rigid3d::Exp(-delay_s * velocity_lidar);
  return calibration;
}

}  // namespace tvl
