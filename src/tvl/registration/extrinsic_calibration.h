// Where the camera points, seen from the lidar: finds the error of the given extrinsic rotation
// while driving.
//
// Over some metres of way the lidar's motion is known well, and the same motion seen through a
// camera that points elsewhere does not fit the tracks: they leave their epipolar planes, by the
// angle the camera is off where it moves straight on. So tracks over a few metres of way are
// compared with the motion between, whose own error is estimated beside the camera's (hand-eye
// calibration with a moving camera; Tsai, Lenz: A new technique for fully autonomous and efficient
// 3D robotics hand/eye calibration, 1989).
//
// Poses that believe a wrong camera follow it, and agree with it. So until the extrinsics have been
// checked, poses of the lidar alone are asked, too (extrinsic_check.h).
//
// Extrinsics are believed until the drive contradicts them. From then on what the camera says of
// the direction of motion counts for as little as that deserves (ExtrinsicError in pose_problem.h):
// poses that a wrong camera has pulled along would hide its error.
//
// Tracks do not tell the translation (2 cm of it change what is seen in a curve by less than the
// motion is known to) nor the delay of the images (at constant speed it is a translation): outlines
// do, see camera_offset.h.
#pragma once

#include <Eigen/Core>

#include "tvl/frame/feature_tracks.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/registration/camera_offset.h"
#include "tvl/registration/edge_alignment.h"
#include "tvl/registration/extrinsic_check.h"
#include "tvl/registration/hand_eye.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct ExtrinsicCalibrationOptions {
  bool enabled = true;
  // Way between the two images of a window: far enough to see the direction of motion within 0.1
  // deg, near enough that tracks last and odometry does not drift.
  double window_m = 4.0;
  int max_frames = 30;  // of a window: slower, the stretch is let go
  int min_tracks = 30;  // in both images of a window
  double corner_sigma_px = 0.5;
  // Of the motion over a window, as odometry knows it: rotation, and translation a metre of way.
  double motion_sigma_rad = 3e-4;
  double motion_sigma_share = 0.00125;
  // What extrinsics are usually off by, one standard deviation: what is not observed is not
  // corrected. Counts for what is left after each correction.
  double prior_rad = 0.0044;  // 0.25 deg
  // Directions of motion that all windows share are biased by this much: beams, vegetation that is
  // seen deeper the nearer one comes.
  double bias_rad = 5e-4;      // 0.03 deg
  double memory_windows = 50;  // after which a window counts for 1/e
  // From an error of so many standard deviations on, the extrinsics count as uncertain.
  double doubt_significance = 2.0;
  double min_significance = 3.0;  // of a correction, in standard deviations; smaller is not used
  bool use_edges = true;          // outlines in the scan against the image's
  EdgeAlignmentOptions edges;
  CameraOffsetOptions offset;
  ExtrinsicCheckOptions check;
  void Check() const;  // throws InputError naming the field
};

// What is known of the extrinsic rotation. Right in T_cam_lidar = Exp(rotation) * T_given, rotation
// about the camera's axes x (right), y (down), z (forward).
struct ExtrinsicEstimate {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();  // best estimate of the whole error
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();     // its standard deviations
  Eigen::Vector3d applied_rad = Eigen::Vector3d::Zero();   // of it, what T_cam_lidar() holds
  int windows = 0;                                         // that were compared
  int edge_images = 0;                                     // whose outlines count
  CameraOffsetEstimate offset;                             // in time and place
};

class ExtrinsicCalibration {
 public:
  // Throws InputError for unusable options.
  ExtrinsicCalibration(const Calibration& given, const ExtrinsicCalibrationOptions& options);

  // Takes the tracks of one frame, without those on moving things, and the measured pose of the
  // lidar when its image was taken. True if T_cam_lidar() or delay_s() changed.
  bool Add(const FeatureTracks& tracks, const Rigid3d& T_odom_lidar);
  // True if AddEdges is to be called for the frame with that pose. To be asked once a frame.
  bool WantsEdges(const Rigid3d& T_odom_lidar);
  // Takes the outlines of a frame, found with T_cam_lidar() and delay_s(). True if one changed.
  bool AddEdges(EdgeProfiles edges);
  // True while AddLidarOnly is to be called for each frame.
  bool WantsLidarOnly() const { return options_.enabled && check_.IsDue(); }
  // Takes the tracks of one frame, as Add does, and the pose of the lidar when its image was taken,
  // found without the camera. True if T_cam_lidar() changed.
  bool AddLidarOnly(const FeatureTracks& tracks, const LidarPose& pose);
  // What was seen before does not continue: the pose was lost, or moved.
  void Forget() {
    views_.Forget();
    check_.Forget();
  }
  // The same of poses of the lidar alone.
  void ForgetLidarOnly() { check_.Forget(); }

  // The extrinsics to use: as given, until a correction is significant.
  const Rigid3d& T_cam_lidar() const { return T_cam_lidar_; }
  // How late the images are taken to be; zero until that is significant.
  double delay_s() const { return applied_delay_s_; }
  // Zero until something contradicts them. Then what may be wrong with them: mean square error of
  // the rotation, camera axes, rad^2, with what is believed to be wrong but not yet corrected.
  Eigen::Matrix3d RemainingError() const;
  ExtrinsicEstimate estimate() const;

 private:
  // What edges say of the rotation that is left; zero where tracks contradict them.
  Eigen::Matrix3d EdgeInformation() const;
  // Of the error that is left in T_cam_lidar().
  Eigen::Matrix3d Information() const;
  Eigen::Matrix3d Covariance() const;
  Eigen::Vector3d Remaining() const;
  void Turn(const Eigen::Vector3d& correction_rad, double kept);
  bool Apply();
  bool ApplyDelay();

  ExtrinsicCalibrationOptions options_;
  Rigid3d given_, T_cam_lidar_;
  Eigen::Vector3d applied_rad_ = Eigen::Vector3d::Zero();
  HandEyeOptions hand_eye_;
  HandEyeWindows views_;
  // Normal equations of the rotation that is left, linearised at T_cam_lidar_; the motions of the
  // windows marginalised out.
  Eigen::Matrix3d H_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
  int windows_ = 0;
  ExtrinsicCheck check_;
  EdgeAlignment edges_;
  CameraOffset offset_;
  double applied_delay_s_ = 0.0;
  bool in_doubt_ = false;
};

}  // namespace tvl
