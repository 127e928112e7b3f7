// The calibration files of KITTI, odometry and raw.
//
// Both describe rectified cameras 0..3 (0, 1 grey, 2, 3 colour) by 3x4 matrices P_N that map
// rectified camera-0 coordinates to pixels of image N. P_N = K_N [I | K_N^-1 p4]: the fourth column
// places camera N, so T_camN_lidar = [I | K_N^-1 p4] T_cam0_lidar, its z entry included.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "tvl/sensor/calibration.h"

namespace tvl {

struct KittiCalibration {
  std::string source;  // the file, for errors
  std::array<std::optional<Matrix34d>, 4> P;
  Rigid3d T_cam0_lidar;   // into rectified camera 0
  Rigid3d rectification;  // into rectified camera 0 from camera 0; of a raw drive
};

// The rigid motion that a 3x4 matrix of a calibration is. Throws InputError beginning with `where`
// where its left 3x3 is no rotation.
Rigid3d RigidOfMatrix(const Matrix34d& m, const std::string& where);

// calib.txt of a sequence in the odometry layout: P0..P3, Tr (or Tr_velo_to_cam).
// Throws InputError naming file, line and key.
KittiCalibration ReadOdometryCalibration(const std::string& path);

// calib_cam_to_cam.txt (P_rect_0N, R_rect_00) and calib_velo_to_cam.txt (R, T) of a raw date
// folder: T_cam0_lidar = R_rect_00 T_velo_to_cam. Throws InputError naming file, line and key.
KittiCalibration ReadRawCalibration(const std::string& date_folder);

// Calibration for camera 0..3; the image size stays unknown (0). Throws InputError if P_N is
// missing or not a pinhole camera.
Calibration CalibrationOfCamera(const KittiCalibration& kitti, int camera);

// Of one camera, which is camera 0 as well: of a simulated drive.
KittiCalibration KittiCalibrationOf(const Calibration& calibration);

// calib.txt with the matrices there are and Tr. Throws InputError if it cannot be written.
void WriteOdometryCalibration(const std::string& path, const KittiCalibration& kitti);

// calib_velo_to_cam.txt of a raw drive, whose other files stay. Throws as above.
void WriteRawExtrinsics(const std::string& path, const KittiCalibration& kitti);

// Calibration without a camera: T_cam_lidar = T_cam0_lidar, no intrinsics.
Calibration CalibrationWithoutCamera(const KittiCalibration& kitti);

}  // namespace tvl
