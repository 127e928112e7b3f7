// Trajectory files: KITTI (a 3x4 matrix a line) and TUM (time, position, quaternion a line).
#pragma once

#include <string>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/map/trajectory.h"

namespace tvl {

// Poses of camera 0 relative to the first one, as KITTI's ground truth has them:
// T_cam0first_cam0k = T_cam0_lidar T_lidarfirst_lidark T_cam0_lidar^-1. The first is the identity.
std::vector<Rigid3d> ToKittiPoses(const Trajectory& trajectory, const Rigid3d& T_cam0_lidar);

// 12 numbers a line, row by row. Reading throws InputError naming file and line; rotations that
// are off by more than rounding are errors, the rest are made orthonormal. Writing is atomic.
std::vector<Rigid3d> ReadKittiPoses(const std::string& path);
void WriteKittiPoses(const std::string& path, const std::vector<Rigid3d>& poses);

// "seconds x y z qx qy qz qw" a line, seconds with 9 decimals, '#' begins a comment; T_world_lidar.
// Frames are numbered from 0 on reading. Errors as above.
Trajectory ReadTumTrajectory(const std::string& path);
void WriteTumTrajectory(const std::string& path, const Trajectory& trajectory);

}  // namespace tvl
