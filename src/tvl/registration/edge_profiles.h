// Outlines of things in a scan, and what the image shows across each of them.
//
// Where the range jumps between neighbouring points, something ends, and where something ends the
// image has an edge. On a line across each outline the strength of the image's gradient is read
// (Levinson, Thrun: Automatic online calibration of cameras and lasers, RSS 2013). How far the line
// would have to be moved to have its middle on the edge is told by the derivatives beside it.
//
// Both sides of things are used: outlines lie half a step of the lidar outside the last point on
// average, and what a beam's width adds on one side it takes away on the other. Of upper ends
// there is one side only, which is why the vertical direction is known less well.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/frame/segmented_scan.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// What moves outlines in the image, in this order: the camera's rotation (rad) and translation (m),
// right in T_cam_lidar = Exp(rotation, translation) * T_given, camera axes; the width by which the
// lidar sees things too large (rad); the time by which the image is late (s).
using EdgeVector = Eigen::Matrix<double, 8, 1>;
using EdgeMatrix = Eigen::Matrix<double, 8, 8>;
constexpr int kEdgeWidth = 6, kEdgeDelay = 7;  // of an EdgeVector

// One outline: the image's gradient on a line across it.
struct EdgeProfile {
  static constexpr double kStep_rad = 0.0013;  // between samples, 0.075 deg: a pixel or less
  static constexpr int kReach = 26;            // samples to either side: 2 deg
  // Width of the smoothing: 0.12 deg is how far single outlines scatter, half a step of the lidar.
  static constexpr double kFine_samples = 1.6;
  using Samples = std::array<float, 2 * kReach + 1>;

  bool is_upright = true;  // a left or right end: read along the row; else an upper end
  // Against its mean along the line, finely and coarsely smoothed.
  Samples fine, coarse;
  Eigen::Matrix<double, 1, 8> J;  // of the position, in samples, by an EdgeVector
  int group = 0;                  // those of one thing share their errors
};

struct EdgeProfiles {
  std::vector<EdgeProfile> profiles;
  double turning_rad_s = 0.0;  // how fast the vehicle turned
};

// `points_lidar` are the scan's, moved to the time of the image `grey` (8 bit, as delivered), while
// the vehicle moves at `velocity_lidar`: rotation (rad/s) and translation (m/s), lidar axes.
EdgeProfiles FindEdgeProfiles(const cv::Mat& grey, const SegmentedScan& scan,
                              const std::vector<Eigen::Vector3f>& points_lidar,
                              const Camera& camera, const Rigid3d& T_cam_lidar,
                              const Vector6d& velocity_lidar, int max_edges);

}  // namespace tvl
