// Extrinsics for points whose vertical correction the calibration did not know of.
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

// KITTI's T_cam_lidar was estimated from points as stored; it has absorbed the vertical error of
// the lidar where the camera looks (measured: stored points fit the images, corrected ones lie 2.6
// px too high). Returns the T_cam_lidar that maps a CORRECTED point on the camera's axis to where
// T_cam_lidar maps the stored one, so that corrected points serve lidar and camera alike.
// `correction_rad` is LidarModel::vertical_correction_rad: the rotation of a point p about p x z.
// Unchanged for a camera that looks straight up or down.
Rigid3d ExtrinsicsOfCorrectedPoints(const Rigid3d& T_cam_lidar, double correction_rad);

}  // namespace tvl
