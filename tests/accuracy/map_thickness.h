// How thin the surfaces of a map are: a measure of poses that needs no truth. Wrong poses lay the
// scans side by side instead of on top of each other.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/geometry/voxel_hash.h"

namespace tvl {

struct ThicknessOptions {
  double voxel_m = 0.5;  // small enough for facades to be flat in it, holds several rings
  int min_points = 20;   // of a voxel
  int min_scans = 3;     // a voxel seen by fewer says nothing of their alignment
  // Nearer: the car; farther: the width of the beams exceeds the errors looked for.
  double min_range_m = 5.0, max_range_m = 40.0;
  double max_flatness = 0.1;   // smallest to middle eigenvalue of the scatter: flat ...
  double max_linearity = 0.9;  // ... and 1 - middle to largest: not a single scan line
};

struct Thickness {
  double rms_m = 0.0;     // of the distances of all points to the planes of their voxels
  int planar_voxels = 0;  // voxels that make it up
  int filled_voxels = 0;  // voxels with enough points from enough scans, planar or not
};

// Gathers scan after scan; memory grows with the volume of the map, not with the scans.
class ThicknessMeter {
 public:
  explicit ThicknessMeter(const ThicknessOptions& options = {}) : options_(options) {}

  // `p_lidar`: points of one scan, compensated to its pose, m.
  void Add(const std::vector<Eigen::Vector3f>& p_lidar, const Rigid3d& T_world_lidar);
  Thickness Result() const;

 private:
  // Moments about the centre of the voxel.
  struct Moments {
    int points = 0, scans = 0, last_scan = -1;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  };

  ThicknessOptions options_;
  VoxelHash<Moments> voxels_;
  int scan_ = 0;
};

}  // namespace tvl
