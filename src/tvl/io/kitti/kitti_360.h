// The layout of KITTI-360 as it is distributed:
//   ROOT/data_3d_raw/DRIVE/velodyne_points/{data,timestamps.txt}
//   ROOT/data_2d_raw/DRIVE/image_0N/{data_rect,timestamps.txt}    N = 0, 1: the stereo pair
//   ROOT/calibration/{calib_cam_to_velo,perspective,calib_cam_to_pose}.txt
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tvl/io/kitti_calibration.h"
#include "tvl/io/recording.h"

namespace tvl {

struct Kitti360Calibration {
  // T_cam0_lidar leads into rectified camera 0: R_rect_00 T_velo_cam0^-1 with calib_cam_to_velo =
  // T_velo_cam0; P from P_rect_00 and P_rect_01.
  KittiCalibration kitti;
  // calib_cam_to_pose: cameras 0, 1 before rectification in the frame of the GPS/IMU; empty where
  // the file is not there.
  std::array<std::optional<Rigid3d>, 2> T_pose_cam;
};

// Throws InputError naming file, line and key.
Kitti360Calibration ReadKitti360Calibration(const std::string& calibration_folder);

// Whether `path` is ROOT or one of its data_3d_raw/DRIVE. Looks at names only.
bool LooksLikeKitti360(const std::string& path);

// `path`: ROOT with one drive, or ROOT/data_3d_raw/DRIVE. Scans and rectified images of camera 0
// (else 1), each with its own stamps, which the line of its file number has. Throws InputError
// naming folder or file: no scans, several drives, no calibration, malformed text files, fewer
// stamps than the last file's number.
Recording OpenKitti360(const std::string& path);

}  // namespace tvl
