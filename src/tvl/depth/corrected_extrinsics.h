// Extrinsics for points whose vertical correction the calibration did not know of.
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

// An extrinsic calibration estimated from points as stored has absorbed the lidar's vertical error
// where the camera looks. So it is on KITTI: edges in the images of drive 2011_09_26_0052 lie where
// the stored points say, within 0.05 deg, and 2.6 px from where corrected ones do. On KITTI-360
// they lie in between, 0.13 deg above the stored points.
// Returns the T_cam_lidar that maps a CORRECTED point on the camera's axis to where T_cam_lidar
// maps the stored one, so that corrected points serve lidar and camera alike.
// `correction_rad` is LidarModel::vertical_correction_rad: the rotation of a point p about p x z.
// Unchanged for a camera that looks straight up or down.
Rigid3d ExtrinsicsOfCorrectedPoints(const Rigid3d& T_cam_lidar, double correction_rad);

}  // namespace tvl
