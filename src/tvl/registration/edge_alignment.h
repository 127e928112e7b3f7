// Where the camera points, seen from edges: outlines of things in the scan against the image.
//
// Where the range jumps between neighbouring points, something ends, and where something ends the
// image has an edge. On a line across each outline the strength of the image's gradient is read;
// over hundreds of outlines, the shift at which the gradients add up is the error of the extrinsics
// there (Levinson, Thrun: Automatic online calibration of cameras and lasers, RSS 2013). One image
// tells some tenths of a degree without a metre driven; twenty tell hundredths.
//
// Both sides of things are used: outlines lie half a step of the lidar outside the last point on
// average, and what a beam's width adds on one side it takes away on the other. Of upper ends
// there is one side only, which is why the vertical direction is known less well.
#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/frame/segmented_scan.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct EdgeAlignmentOptions {
  int max_edges = 400;  // of one image
  int max_images = 20;  // that are looked at together: the newest
  // Between two images: the same view does not tell more the second time.
  double min_way_m = 0.5;
  // The first images are taken every so many frames; once max_images are there, four times as many.
  int every_frames = 2;
  // Of all edges alike, one standard deviation: across (three drives with an HDL-64E agree in 0.12
  // deg: so well is its azimuth stamped), up (upper ends are rounded; the beams' elevation), and
  // about the axis.
  double bias_across_rad = 1.4e-3;  // 0.08 deg
  double bias_up_rad = 1.7e-3;      // 0.1 deg
  double bias_about_rad = 1.7e-3;   // 0.1 deg
  void Check() const;               // throws InputError naming the field
};

// One outline: the image's gradient on a line across it.
struct EdgeProfile {
  static constexpr double kStep_rad = 0.0013;  // between samples, 0.075 deg: a pixel or less
  static constexpr int kReach = 26;            // samples to either side: 2 deg
  using Samples = std::array<float, 2 * kReach + 1>;

  bool is_upright = true;  // a left or right end: read along the row; else an upper end
  // Against its mean along the line, finely and coarsely smoothed.
  Samples fine, coarse;
  // Of the position, in samples, by the camera's rotation (rad) and translation (m), and by the
  // width by which the lidar sees things too large (rad).
  Eigen::Matrix<double, 1, 7> J;
  int group = 0;  // those of one thing share their errors
};

struct EdgeProfiles {
  std::vector<EdgeProfile> profiles;
};

// `points_lidar` are the scan's, moved to the time of the image `grey` (8 bit, as delivered).
EdgeProfiles FindEdgeProfiles(const cv::Mat& grey, const SegmentedScan& scan,
                              const std::vector<Eigen::Vector3f>& points_lidar,
                              const Camera& camera, const Rigid3d& T_cam_lidar, int max_edges);

// What edges say: the error of the rotation, as in ExtrinsicEstimate.
struct EdgeEstimate {
  int images = 0;  // 0: nothing is known
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  // Inverse of the covariance, with the biases; zero in directions without a clear answer.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

class EdgeAlignment {
 public:
  explicit EdgeAlignment(const EdgeAlignmentOptions& options);

  // True if the image of this frame is to be read. To be asked once a frame.
  bool IsDue(const Rigid3d& T_odom_lidar);
  // Profiles read with extrinsics that are `rotation_rad` away from those given.
  void Add(EdgeProfiles edges, const Eigen::Vector3d& rotation_rad);
  const EdgeEstimate& estimate() const { return estimate_; }

 private:
  struct Image {
    EdgeProfiles edges;
    Eigen::Vector3d rotation_rad;
  };
  EdgeAlignmentOptions options_;
  std::deque<Image> images_;
  EdgeEstimate estimate_;
  int frames_since_ = 0;
  bool has_image_ = false;
  Rigid3d T_odom_last_;
};

}  // namespace tvl
