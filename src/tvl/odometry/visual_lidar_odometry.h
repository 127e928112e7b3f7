// Tightly coupled visual lidar odometry (paper 5.1, Algorithm 1): the motion between consecutive
// frames from laser and visual features in one optimisation.
#pragma once

#include <memory>
#include <optional>

#include "tvl/base/parallel.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/frame/preprocessed_frame.h"
#include "tvl/odometry/laser_matcher.h"
#include "tvl/odometry/road_motion.h"
#include "tvl/odometry/visual_matcher.h"
#include "tvl/registration/pose_problem.h"

namespace tvl {

struct OdometryOptions {
  // false: not estimated where the map step begins as well with the predicted motion, see
  // FrameTracker.
  bool enabled = true;
  LaserMatchOptions laser;
  VisualMatchOptions visual;
  RoadMotionOptions road;
  double kernel_sigmas = 2.0;                    // laser, Cauchy
  double visual_kernel_sigmas = 2.0;             // Huber
  double visual_gate_sigmas = 3.0;               // of visual matches against laser and prior
  int max_refreshes = 5;                         // of the correspondences
  double first_gate_m = 1.5, last_gate_m = 0.5;  // of laser matches; halved each refresh
  double stop_rotation_rad = 5e-5, stop_translation_m = 1e-3;
  int min_matches = 60;  // fewer laser and visual residuals: not an estimate
  // Before any velocity is known, forward speeds of up to this are tried.
  double max_start_step_m = 3.0;
  bool use_camera = true;
  WeaknessOptions weakness;
  CovarianceOptions covariance;
  void Check() const;
};

// What odometry is told of the motion before it looks: where to start, and the prior.
struct MotionGuess {
  Rigid3d T_prev_cur;
  // Right perturbation, [rotation, translation]; positive definite. Only used when known.
  Matrix6d covariance = Matrix6d::Identity();
  bool known = false;  // false: no velocity yet; forward speeds are tried, and there is no prior
  bool use_camera = true;  // false: the laser alone, whatever the options say
};

class VisualLidarOdometry {
 public:
  VisualLidarOdometry(const Calibration& calibration, const OdometryOptions& options);

  bool has_previous() const {
    return matcher_ != nullptr || !previous_visual_.tracks.tracks.empty();
  }

  // T_prev_cur of `frame` against the frame last given to Advance. `period_s` is the time between
  // the two; `bins` says whether scans are raw.
  MotionEstimate Estimate(const PreprocessedFrame& frame, const MotionGuess& guess,
                          const SweepBins& bins, double period_s, const Executor& executor);

  // The motion over the road since the frame last given to Advance. Empty where the tracks on the
  // road do not tell.
  std::optional<RoadMotion> MeasureRoad(const PreprocessedFrame& frame,
                                        const RoadGuess& guess) const;

  // Last step of Algorithm 1: the frame's features, compensated to its stamp, become the
  // reference. `planes` and `edges` are the compensated F_lf and F_ls, in the order of the frame's.
  void Advance(const PreprocessedFrame& frame, std::vector<Eigen::Vector3f> edges,
               std::vector<Eigen::Vector3f> planes);

  // From the next frame on.
  void SetCalibration(const Calibration& calibration) { calibration_ = calibration; }

  // Forgets the reference: the next frame is a first one.
  void Reset();

 private:
  struct Candidate;
  PoseProblem MakeProblem(const MotionGuess& guess, const SweepBins& bins,
                          const Executor& executor) const;
  void Match(const PreprocessedFrame& frame, bool use_camera, const Rigid3d& T_prev_cur,
             double gate_m, const SweepBins& bins, double period_s, PoseProblem* problem);
  // From guess.T_prev_cur; its covariance is the prior if it is known.
  Candidate EstimateFrom(const PreprocessedFrame& frame, const MotionGuess& guess,
                         const SweepBins& bins, double period_s, const Executor& executor);

  Calibration calibration_;
  OdometryOptions options_;
  std::unique_ptr<LaserMatcher> matcher_;
  VisualFeatures previous_visual_;
};

}  // namespace tvl
