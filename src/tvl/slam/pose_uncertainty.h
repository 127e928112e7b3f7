// How far a pose may be off against any earlier one. Three kinds of errors add up, and each grows
// in its own way, none of them with the number of frames:
//   noise   of a pose against the map, new with every scan: as large after a minute of standing as
//           after one frame;
//   walk    of the map itself: surfaces come into view and are mapped from poses that have noise.
//           Its variance grows with the path;
//   bias    of the sensors (elevations of beams, scale of ranges): the same all along the drive in
//           the frame of the body. Its standard deviation grows with the path.
// Errors are right perturbations, [rotation, translation] (rad, m), in the body frame.
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

struct PoseUncertaintyOptions {
  // Of the variance that the weights of the points claim, what is new with every scan. The rest
  // (beams, roughness of surfaces, bends of the map) is alike from scan to scan.
  double noise_share = 0.25;
  // Of the claimed variance, what the map's own error grows by in a metre: along some 25 m the
  // surfaces in view, and with them what their errors share, are replaced by others.
  double walk_per_m = 0.04;
  // Standard deviations of what lasts. Beams whose elevation errors are in proportion to the
  // distance at which they meet the road make a flat road look like a sphere: for 0.08 deg of
  // scatter between the beams of an HDL-64E 0.25 mrad in 10 m cannot be known, and 0.3 to 0.4 were
  // found on simulated streets (docs/decisions.md, 46).
  double bias_level_rad_per_m = 3e-5;  // roll and pitch
  double bias_yaw_rad_per_m = 1e-5;
  double bias_scale = 5e-4;  // of the way: ranges of a calibrated lidar are off by 5 cm in 100 m
  // A pose graph takes its steps to be independent. So does it the bias; its effect is right over
  // this path, too large over less and too small over more, m.
  double independent_path_m = 100.0;
  void Check() const;
};

// What a frame adds.
struct PoseStep {
  Rigid3d T_prev_cur;
  Matrix6d motion_covariance = Matrix6d::Zero();  // of T_prev_cur without the map
  // What scan and landmarks say of the pose against the map; zero: nothing was measured.
  Matrix6d map_information = Matrix6d::Zero();
  // Of what this step makes up for, because the poses before were off by more than they knew.
  Matrix6d beyond_covariance = Matrix6d::Zero();
};

// The error of the newest pose against the map, from frame to frame.
class MapError {
 public:
  explicit MapError(const PoseUncertaintyOptions& options);

  // How a step changes errors.
  struct Change {
    Rigid3d T_prev_cur;
    double length_m = 0.0;
    Matrix6d covariance;   // of the pose against the map, after the step
    Matrix6d persistence;  // error after the step = persistence * error before it + new noise
    Matrix6d walk;         // covariance of the map's own error that the step adds
  };
  Change Add(const PoseStep& step);
  // The map begins anew where the pose is: against it the pose has no error.
  void BeginMap() { covariance_.setZero(); }

  const Matrix6d& covariance() const { return covariance_; }

 private:
  PoseUncertaintyOptions options_;
  Matrix6d covariance_ = Matrix6d::Zero();
};

// The error of the newest pose against one earlier pose, the start.
class RelativeUncertainty {
 public:
  // `start_covariance`: MapError's at the start.
  RelativeUncertainty(const PoseUncertaintyOptions& options, const Matrix6d& start_covariance);

  void Add(const MapError::Change& change);
  // As MapError's.
  void BeginMap();

  // Covariance of T_start_now.
  Matrix6d Covariance() const { return CovarianceWith(1.0); }
  // The same for a graph that takes such steps to be independent.
  Matrix6d CovarianceOfIndependentStep() const;

 private:
  Matrix6d CovarianceWith(double bias_factor) const;  // `bias_factor`: on the bias's variance

  PoseUncertaintyOptions options_;
  Rigid3d T_start_now_;
  double path_m_ = 0.0;
  Matrix6d start_, now_;  // against the map
  Matrix6d cross_;        // of the errors now and at the start, against the map
  Matrix6d walk_ = Matrix6d::Zero();
  // On the pose now: of a turn of 1 rad per metre about each axis, and of a scale that is off by 1.
  Eigen::Matrix<double, 6, 4> bias_effect_ = Eigen::Matrix<double, 6, 4>::Zero();
};

// Of the odometry: the newest pose against the first one, against the last keyframe and against the
// pose before.
class OdometryUncertainty {
 public:
  explicit OdometryUncertainty(const PoseUncertaintyOptions& options);

  // Returns the covariance of the step's T_prev_cur.
  Matrix6d Add(const PoseStep& step);
  // As MapError's.
  void BeginMap();
  // The newest pose is that of a keyframe.
  void BeginKeyframe();

  Matrix6d SinceFirst() const { return since_first_.Covariance(); }
  // Of T_keyframe_now, for a graph.
  Matrix6d SinceKeyframe() const { return since_keyframe_.CovarianceOfIndependentStep(); }
  // Of the newest pose against the map, and what the last step added to the map's own error.
  const Matrix6d& AgainstMap() const { return map_error_.covariance(); }
  const Matrix6d& Walk() const { return walk_; }

 private:
  PoseUncertaintyOptions options_;
  MapError map_error_;
  RelativeUncertainty since_first_, since_keyframe_;
  Matrix6d walk_ = Matrix6d::Zero();
};

}  // namespace tvl
