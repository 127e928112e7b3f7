// One pose from laser matches, visual matches and a prior (paper Eq. 8): what scan-to-scan odometry
// and the map step have in common. They differ in what they match with what, and in the weights.
#pragma once

#include <optional>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/registration/covariance.h"
#include "tvl/registration/laser_terms.h"
#include "tvl/registration/visual_terms.h"
#include "tvl/registration/weakness.h"

namespace tvl {

// What is known of the pose before any match.
struct PriorTerm {
  Rigid3d T;
  Matrix6d information = Matrix6d::Zero();  // right perturbation, [rotation, translation]
  double share = 1.0;                       // of what is known that `information` holds

  static PriorTerm None() { return {}; }
  // `share` of the information of `covariance`, which must be positive definite.
  static PriorTerm Of(const Rigid3d& T, const Matrix6d& covariance, double share = 1.0);
};

// The prior with its whole information along the laser's weak directions: where the prior counts
// for less because laser and camera are in it already, there is no laser to count twice.
PriorTerm WholeAlongWeak(const PriorTerm& prior, const std::vector<WeakDirection>& weak);

// Equations of 0.5 r' information r with r = Log(prior.T^-1 T).
NormalEquations Linearize(const PriorTerm& prior, const Rigid3d& T);

// What extrinsics that are not known exactly do to the camera's measurement of a motion: one error
// of the camera's rotation, common to all visual matches, turns the way it has come. The rotation
// of the motion is hardly touched.
struct ExtrinsicError {
  Rigid3d T_cam_lidar;
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();  // rad^2, camera axes; zero: none

  // A camera that really is at Exp(w) T_cam_lidar shows the motion T_ref_body as one at T_cam_lidar
  // shows T_ref_body Exp(E w): this is E, to first order.
  Eigen::Matrix<double, 6, 3> Effect(const Rigid3d& T_ref_body) const;
};

// The visual equations at a motion with that error eliminated: of the information H remains
// (H^-1 + E C E')^-1, with E the error's effect and C its covariance.
NormalEquations WithExtrinsicError(const NormalEquations& visual,
                                   const Eigen::Matrix<double, 6, 3>& effect,
                                   const Eigen::Matrix3d& rotation_covariance);

struct PoseProblemSetup {
  ExtrinsicError extrinsics;
  // From where visual matches were seen before: the camera measures the motion since. Without a
  // value that of the pose's reference.
  std::optional<Rigid3d> T_ref_seen;
  SweepBins bins;  // of the laser matches
  PriorTerm prior;
  double kernel_sigmas = 2.0;         // laser, Cauchy
  double beam_sigma_rad = 0.0;        // error of a beam's elevation, common to all its points
  double visual_kernel_sigmas = 2.0;  // Huber
  double visual_gate_sigmas = 3.0;    // of visual matches against laser and prior
  WeaknessOptions weakness;
  CovarianceOptions covariance;       // of the pose as reported
  CovarianceOptions gate_covariance;  // of the pose by which visual matches are judged
  // Length of the step the pose stands for, m; without a value the pose is the step itself.
  std::optional<double> step_m;
};

// Minimises 0.5 sum rho(laser) + 0.5 sum rho(visual) + prior, where the laser sees the pose with an
// unknown shift along its weak directions (LaserShift). Correspondences, weak directions and gated
// matches stay as SetMatches left them, so that the solver compares values of one function.
class PoseProblem {
 public:
  // `executor` must outlive the problem.
  PoseProblem(const PoseProblemSetup& setup, const Executor& executor);

  // Takes correspondences found at T, judges the laser's weak directions there, and drops visual
  // matches that contradict what laser and prior say near T.
  void SetMatches(LaserMatches laser, VisualMatches visual, const Rigid3d& T);

  const LaserMatches& laser() const { return laser_; }
  const VisualMatches& visual() const { return visual_; }
  const Weakness& weakness() const { return weakness_; }
  // Number of residual blocks of laser and camera.
  size_t size() const { return laser_.planes.size() + laser_.lines.size() + visual_.size(); }

  // From T, with at most three iterations: correspondences are renewed before more would pay.
  PoseSolution Solve(const Rigid3d& T) const;

  // Laser, camera and prior at a pose with a shift; the solver's cost and equations.
  ShiftedEquations Equations(const ShiftedPose& pose) const;

  // Of a solution: its shift eliminated, inflated, with floors.
  Matrix6d Covariance(const PoseSolution& solution) const;
  // What laser and camera say of a solution, its shift eliminated, as the weights claim.
  Matrix6d Information(const PoseSolution& solution) const;
  // At T without having solved.
  Matrix6d CovarianceAt(const Rigid3d& T) const;

  // Counts and root mean square residuals at T (unshifted). Not filled: iterations, match_share.
  EstimateEvidence Evidence(const Rigid3d& T) const;

 private:
  LaserSum Laser(const Rigid3d& T) const;
  // The error of the extrinsics eliminated.
  VisualSum Visual(const Rigid3d& T) const;
  Eigen::Matrix<double, 6, 3> EffectOfExtrinsics(const Rigid3d& T) const;
  ShiftedEquations WithoutCamera(const ShiftedPose& pose) const;
  VisualMatches Gated(const Rigid3d& T) const;
  Matrix6d CovarianceOf(const Matrix6d& H, const Rigid3d& T,
                        const CovarianceOptions& options) const;

  PoseProblemSetup setup_;
  const Executor& executor_;
  LaserMatches laser_;
  VisualMatches visual_;
  PriorTerm prior_;            // whole along weak directions
  size_t visual_offered_ = 0;  // visual matches before those that contradict were dropped
  Weakness weakness_;
  // The laser's sum where it was matched: weakness, gate and solver begin there.
  Rigid3d T_matched_;
  LaserSum laser_matched_;
};

}  // namespace tvl
