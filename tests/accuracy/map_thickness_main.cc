// tvl_map_thickness SEQUENCE POSES none|cw|ccw: map thickness of a KITTI odometry folder and a pose
// file of camera 0 (one line a frame), as one line of JSON. Raw scans are compensated by the motion
// between the poses, as constant over a sweep.
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include "map_thickness.h"
#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/io/kitti_layout.h"
#include "tvl/io/profile.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/io/velodyne_bin.h"
#include "tvl/lidar/deskew.h"

namespace tvl {
namespace {

// The elevation of each point raised by angle_rad, its range kept.
void RaiseElevation(double angle_rad, std::vector<Eigen::Vector3f>* points) {
  for (Eigen::Vector3f& p : *points) {
    const double across_m = std::hypot(p.x(), p.y());
    if (across_m == 0.0) continue;
    const double elevation_rad = std::atan2(p.z(), across_m) + angle_rad;
    const double range_m = std::hypot(across_m, p.z());
    const double scale = range_m * std::cos(elevation_rad) / across_m;
    p = Eigen::Vector3d(p.x() * scale, p.y() * scale, range_m * std::sin(elevation_rad))
            .cast<float>();
  }
}

// Seconds from the middle of the sweep, which starts behind and faces +x in its middle.
std::vector<float> SweepOffsets(const std::vector<Eigen::Vector3f>& points, bool is_clockwise,
                                double sweep_s) {
  std::vector<float> offsets_s;
  offsets_s.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    const double share = std::atan2(p.y(), p.x()) / (2.0 * kPi);
    offsets_s.push_back(static_cast<float>((is_clockwise ? -share : share) * sweep_s));
  }
  return offsets_s;
}

Thickness Measure(const std::string& sequence, const std::string& poses, const std::string& spin) {
  TVL_CHECK_INPUT(spin == "none" || spin == "cw" || spin == "ccw") << spin << ": none, cw or ccw";
  const LidarModel lidar = LoadProfile("kitti");
  const KittiLayout layout = FindKittiLayout(sequence);
  const Rigid3d& T_cam0_lidar = layout.calibration.T_cam0_lidar;
  const std::vector<Rigid3d> T_world_cam0 = ReadKittiPoses(poses);
  TVL_CHECK_INPUT(T_world_cam0.size() == layout.frames.size() && T_world_cam0.size() > 1)
      << poses << ": " << T_world_cam0.size() << " poses, " << layout.frames.size() << " frames";
  ThicknessMeter meter;
  for (size_t k = 0; k < layout.frames.size(); ++k) {
    const ScanRead read = ReadVelodyneBin(layout.frames[k].scan_path, ScanExpectation());
    if (read.scan == nullptr) continue;
    std::vector<Eigen::Vector3f> points = read.scan->points;
    RaiseElevation(lidar.vertical_correction_rad, &points);
    if (spin != "none") {  // the first frame moves as the second
      const size_t i = k == 0 ? 1 : k;
      const Rigid3d T_prev_cur =
          T_cam0_lidar.Inverse() * (T_world_cam0[i - 1].Inverse() * T_world_cam0[i]) * T_cam0_lidar;
      points = DeskewPoints(points, SweepOffsets(points, spin == "cw", lidar.sweep_s), T_prev_cur,
                            lidar.sweep_s);
    }
    meter.Add(points, T_world_cam0[k] * T_cam0_lidar);
  }
  return meter.Result();
}

}  // namespace
}  // namespace tvl

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "tvl_map_thickness SEQUENCE POSES none|cw|ccw\n";
    return 2;
  }
  try {
    const tvl::Thickness t = tvl::Measure(argv[1], argv[2], argv[3]);
    std::printf("{\"thickness_mm\": %.4f, \"planar_voxels\": %d, \"filled_voxels\": %d}\n",
                1e3 * t.rms_m, t.planar_voxels, t.filled_voxels);
  } catch (const std::exception& error) {
    std::cerr << "tvl_map_thickness: " << error.what() << "\n";
    return 2;
  }
  return 0;
}
