// The motion over the road, from visual tracks on it alone. Whatever fills the scan, the road does
// not move: in a traffic jam it is what tells whether the vehicle does.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/odometry/visual_matcher.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

struct RoadMotionOptions {
  double sigma_px = 0.5;             // of the flow between two images
  double max_relative_sigma = 0.15;  // of a depth: vaguer ones say nothing
  double gate_sigmas = 3.0;
  // So many tracks must agree, and this share of all: shadows of other vehicles move over the road
  // with them.
  int min_tracks = 8;
  double min_share = 0.3;
  // A motion whose standard deviation along some direction is larger is none.
  double max_sigma_m = 0.03;
  void Check() const;  // throws InputError naming the field
};

struct RoadMotion {
  Rigid3d T_prev_cur;                                       // rotation and height as guessed
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();  // of x and y
  int tracks = 0;                                           // on the road, seen in both images
  std::vector<size_t> agreeing;  // of them: indices into the current tracks
  int agreeing_with_guess = 0;   // those that RoadGuess::T_prev_cur explains
};

// As a prior beside the tracks it was made of, which count again: of x and y, with what the tracks
// share, such as an error of the road's slope. m^2.
Eigen::Matrix2d CovarianceOf(const RoadMotion& road);

// What is known of the motion beforehand.
struct RoadGuess {
  Rigid3d T_prev_cur;  // rotation and height are believed
  // Of x and y, where and how well they are expected; zero information: anything is possible.
  Eigen::Vector2d expected_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

// Of the tracks on the ground whose depth the lidar knew at the previous frame: the translation x,
// y (lidar frame) that most of them agree on; where that is a close call, the one that was
// expected. Empty if too few agree.
std::optional<RoadMotion> MeasureRoadMotion(const VisualFeatures& previous,
                                            const VisualFeatures& current,
                                            const Calibration& calibration, const RoadGuess& guess,
                                            const RoadMotionOptions& options);

}  // namespace tvl
