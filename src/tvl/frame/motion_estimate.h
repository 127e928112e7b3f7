// What an estimator says about a motion: the value, how well it is known, and why.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

enum class EstimateStatus {
  kFirst,  // nothing to estimate against
  kConverged,
  kNotConverged,  // iterations ran out; the value is the last one
  kPredicted,     // no usable measurement: constant velocity
};
const char* ToString(EstimateStatus status);

// A direction the data holds weakly.
struct WeakDirection {
  bool is_rotation = false;
  Eigen::Vector3d axis_lidar;  // unit, body frame
  double lidar_strength = 0;   // share of the strongest direction's information, lidar alone, 0..1
  double camera_strength = 0;  // same for the camera, against the lidar's strongest
  double say = 0;              // share of its information that the lidar keeps, 0..1 (below 1)
};

// Counts of the measurements that took part.
struct EstimateEvidence {
  int iterations = 0;
  int edges = 0, planes = 0;  // laser residuals in the last iteration
  int visual = 0;             // visual residuals in the last iteration
  int visual_offered = 0;     // before those that contradict laser and prior were left out
  // Matched laser residuals of the last iteration as a share of the laser features offered, 0..1.
  // Odometry: matched at all; map step: matched and within its last gate.
  double match_share = 0;
  double edge_rms_m = 0, plane_rms_m = 0;
  double visual_rms = 0;  // on the normalised image plane: times f gives pixels
};

struct MotionEstimate {
  Rigid3d T_ref_body;  // odometry: T_prev_cur; map step: T_world_lidar
  // Covariance of T_ref_body, right perturbation in the body frame, [rotation, translation].
  Matrix6d covariance = Matrix6d::Identity();
  // What scan and image say of it, without the prior: as claimed by the weights of the residuals.
  Matrix6d information = Matrix6d::Zero();
  EstimateStatus status = EstimateStatus::kFirst;
  EstimateEvidence evidence;
  std::vector<WeakDirection> weak;
};

}  // namespace tvl
