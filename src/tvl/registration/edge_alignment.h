// Where the camera points, seen from edges: outlines of things in the scan against the image.
//
// The shift at which the image's gradients across hundreds of outlines add up is the error of the
// extrinsics there. One image tells some tenths of a degree without a metre driven; twenty tell
// hundredths.
#pragma once

#include <Eigen/Core>
#include <deque>

#include "tvl/geometry/rigid3.h"
#include "tvl/registration/edge_profiles.h"

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

// What edges say: the error of the rotation, as in ExtrinsicEstimate.
struct EdgeEstimate {
  int images = 0;  // 0: nothing is known
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  // Inverse of the covariance, with the biases; zero in directions without a clear answer.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

// With what an image was read, against what was given: rotation as in ExtrinsicEstimate, and by how
// much the image was taken to be late.
struct EdgeReading {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  double delay_s = 0.0;
  EdgeVector operator-(const EdgeReading& other) const {
    EdgeVector moved = EdgeVector::Zero();
    moved.head<3>() = rotation_rad - other.rotation_rad;
    moved[kEdgeDelay] = delay_s - other.delay_s;
    return moved;
  }
};

// What is known of the images' delay from elsewhere.
struct DelayBelief {
  double delay_s = 0.0, sigma_s = 0.005;
};

class EdgeAlignment {
 public:
  explicit EdgeAlignment(const EdgeAlignmentOptions& options);

  // True if the image of this frame is to be read. To be asked once a frame.
  bool IsDue(const Rigid3d& T_odom_lidar);
  void Add(EdgeProfiles edges, const EdgeReading& reading, const DelayBelief& delay = {});
  const EdgeEstimate& estimate() const { return estimate_; }

 private:
  struct Image {
    EdgeProfiles edges;
    EdgeReading reading;
  };
  EdgeAlignmentOptions options_;
  std::deque<Image> images_;
  EdgeEstimate estimate_;
  int frames_since_ = 0;
  bool has_image_ = false;
  Rigid3d T_odom_last_;
};

}  // namespace tvl
