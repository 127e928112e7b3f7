// Whether the given extrinsics can be believed, asked of poses that the camera has no part in.
//
// Poses that believe the camera follow it, and the motion between them agrees with it whatever its
// error: 0.9 deg to the side were taken for 0.01 +- 0.06 deg. Poses from the lidar alone do not,
// and their windows of hand-eye calibration tell that error at once. They are off by more than
// scatter: beams, and hedges that are seen deeper the nearer one comes, turn the direction of
// motion of all windows alike. So small errors stay with ExtrinsicCalibration, and the check is
// over when more windows would not tell more.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tvl/registration/hand_eye.h"

namespace tvl {

struct ExtrinsicCheckOptions {
  bool enabled = true;
  // What the direction of motion of the lidar alone is off by in all windows alike, one standard
  // deviation.
  double bias_rad = 1.75e-3;  // 0.1 deg
  // Windows before anything is said: of one or two nearly all may lie on a thing that moves.
  int min_windows = 3;
  void Check() const;  // throws InputError naming the field
};

class ExtrinsicCheck {
 public:
  // `prior_rad`: what extrinsics are usually off by, for the rotation about the camera's axis,
  // which a straight road does not tell. `min_significance`: of a correction, in standard
  // deviations.
  ExtrinsicCheck(const ExtrinsicCheckOptions& options, const HandEyeOptions& hand_eye,
                 double prior_rad, double min_significance);

  // More windows are wanted.
  bool IsDue() const { return options_.enabled && !has_passed_; }
  // Takes the tracks of one frame, without those on moving things, and the pose of the lidar when
  // its image was taken, found without the camera. Returns a significant error of the extrinsics:
  // right is Exp(rotation) * T_cam_lidar, rad, camera axes. The check then begins anew, with those.
  std::optional<Eigen::Vector3d> Add(const FeatureTracks& tracks, const LidarPose& pose,
                                     const Rigid3d& T_cam_lidar);
  // What was seen before does not continue.
  void Forget() { views_.Forget(); }

 private:
  struct Error {
    Eigen::Vector3d rotation_rad;  // as Add returns it
    Eigen::Matrix3d scatter;       // its covariance, rad^2, without the bias
  };
  Error Solve(const Rigid3d& T_cam_lidar) const;

  ExtrinsicCheckOptions options_;
  HandEyeOptions hand_eye_;
  double prior_rad_, min_significance_;
  HandEyeWindows views_;
  std::vector<HandEyeWindow> windows_;
  bool has_passed_ = false;
};

}  // namespace tvl
