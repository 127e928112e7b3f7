// Hand-eye calibration with a moving camera (Tsai, Lenz: A new technique for fully autonomous and
// efficient 3D robotics hand/eye calibration, 1989): tracks over a window of way against the motion
// of the lidar between, whose own error is estimated beside the camera's rotation.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "tvl/factors/epipolar.h"
#include "tvl/frame/feature_tracks.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct HandEyeOptions {
  double window_m = 4.0;                // way between the two images of a window
  int max_frames = 30;                  // of a window: slower, the stretch is let go
  int min_tracks = 30;                  // in both images of a window
  double corner_sigma_rad = 9e-4;       // of a ray, one standard deviation
  double motion_sigma_rad = 3e-4;       // of the motion over a window: rotation ...
  double motion_sigma_share = 0.00125;  // ... and translation a metre of way
};

// A pose of the lidar and what it is off by against the map, independent from pose to pose.
struct LidarPose {
  Rigid3d T_odom_lidar;
  Matrix6d covariance = Matrix6d::Zero();  // right perturbation, [rotation, translation], rad, m
};

// What two images and the poses between which they were taken say.
struct HandEyeWindow {
  std::vector<Epipolar> rays;  // of the tracks in both
  Rigid3d T_from_to;           // motion of the lidar
  Matrix6d information;        // of that motion, right perturbation
};

// Finds the windows along the way.
class HandEyeWindows {
 public:
  explicit HandEyeWindows(const HandEyeOptions& options) : options_(options) {}

  // Takes the tracks of one frame and the pose of the lidar when its image was taken. A window,
  // where one ends with it.
  std::optional<HandEyeWindow> Add(const FeatureTracks& tracks, const LidarPose& pose);
  // What was seen before does not continue.
  void Forget() { views_.clear(); }

 private:
  struct View {
    LidarPose pose;
    std::vector<std::pair<TrackId, Eigen::Vector3d>> rays_cam;  // unit, by increasing id
  };
  // The view from which the newest is a window away, or null.
  const View* FindStart() const;
  HandEyeWindow WindowBetween(const View& from, const View& to) const;

  HandEyeOptions options_;
  std::deque<View> views_;
};

// Normal equations H w = -b of the rotation w that is missing in the extrinsics, camera axes,
// 1/rad^2 and 1/rad; the motion of the window marginalised out.
struct HandEyeEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

// Of a window at the extrinsics T_cam_lidar; nothing where too few tracks tell.
std::optional<HandEyeEquations> Linearize(const HandEyeWindow& window, const Rigid3d& T_cam_lidar,
                                          const HandEyeOptions& options);

}  // namespace tvl
