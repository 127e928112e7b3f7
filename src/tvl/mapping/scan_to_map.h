// Scan-to-map matching (paper 5.2): refines T_world_lidar against the local map, with the camera's
// landmarks and the odometry's prediction beside the laser, so that a tunnel does not slide.
#pragma once

#include "tvl/base/parallel.h"
#include "tvl/frame/laser_features.h"
#include "tvl/frame/motion_estimate.h"
#include "tvl/mapping/landmark_map.h"
#include "tvl/mapping/local_map.h"
#include "tvl/registration/pose_problem.h"

namespace tvl {

// Against a map of many scans most of what residuals share averages out.
inline CovarianceOptions ForMapStep() {
  CovarianceOptions options;
  options.inflation = 1.5;
  return options;
}

struct ScanToMapOptions {
  // Thinning of F_lf before matching. Even coverage keeps the far road in proportion: where the
  // near one crowds it out, errors of single beams tilt the pose (measured: 0.5 m drifts 1.2 x as
  // much).
  double source_voxel_m = 1.0;
  double sensor_sigma_m = 0.03;    // of a point across a surface; range noise and beam bias
  double beam_sigma_rad = 0.0014;  // of a beam's elevation (0.08 deg): 6 cm of height at 40 m
  // Of a beam's elevation against the map, common to all points of the beam: its own 0.08 deg and
  // as much of the beams that made the map. A beam's points are no more than one witness of the
  // pitch.
  double common_beam_sigma_rad = 0.002;  // 0.11 deg; 0: the errors of all points are independent
  double edge_sigma_m = 0.10;  // of a point across an edge: edges are where beams happen to hit
  double kernel_sigmas = 2.0;  // Cauchy
  double visual_kernel_sigmas = 2.0;  // Huber
  double visual_gate_sigmas = 3.0;    // of landmarks against laser and prior
  int max_refreshes = 6;              // of the correspondences
  double first_gate_m = 1.0;          // matches further off are dropped; halved each refresh ...
  double last_gate_m = 0.25;          // ... down to this
  double stop_rotation_rad = 2e-5, stop_translation_m = 5e-4;  // step that ends the refreshes
  int min_matches = 60;  // fewer laser and visual residuals: not an estimate
  // The prior counts for this share of its information: camera and laser are in it already.
  double prior_share = 0.25;
  bool use_camera = true;
  WeaknessOptions weakness;
  // Of the pose given the one before, for what is predicted and judged next. What poses tell of
  // each other over time is slam/pose_uncertainty.h.
  CovarianceOptions covariance = ForMapStep();
  // How much wider the pose may be off when landmarks are judged by it: what one scan's residuals
  // share (beams, normals, a moving lorry) is not in their scatter.
  double gate_inflation = 30.0;
  void Check() const;
};

// Where the pose was expected: T_world_lidar of the odometry and the covariance of its last step.
struct PosePrior {
  Rigid3d T_world_lidar;
  Matrix6d covariance = Matrix6d::Identity();  // right perturbation, body
  double step_m = 0.0;                         // length of the step it stands for
};

struct ScanToMapResult {
  MotionEstimate estimate;                               // T_ref_body = T_world_lidar
  double translation_ratio = 1.0, rotation_ratio = 1.0;  // of Weakness
  // Median distance of points to their planes, of those within last_gate_m, m. Unlike plane_rms_m
  // it does not depend on the gate at which the refreshes ended, nor on clutter: its logarithm
  // tells answers to the de-skewing question apart.
  double plane_median_m = 0.0;
  // The plane matches at the end; PlaneMatch::source is an index into MapStepPoints::planes.
  std::vector<PlaneMatch> planes;
};

// Points of F_lf and F_ls as the map step uses them, compensated to the stamp.
struct MapStepPoints {
  std::vector<Eigen::Vector3f> planes, edges;  // p_lidar, m
  std::vector<uint32_t> plane_index;           // of each of `planes` in what they were thinned from
  std::vector<uint16_t> plane_beam;            // of each of `planes`; may be empty
};

// `planes` and `edges` are compensated points in the lidar frame, thinned by the caller or not.
MapStepPoints ThinForMapStep(const std::vector<Eigen::Vector3f>& planes,
                             const std::vector<Eigen::Vector3f>& edges, double voxel_m);

// `landmarks` may be empty. Thread-safe.
ScanToMapResult RefinePose(const MapStepPoints& points, const LocalMap& map,
                           const LandmarkMap& landmarks, const FeatureTracks& tracks,
                           const Calibration& calibration, const PosePrior& prior,
                           const ScanToMapOptions& options, const Executor& executor);

}  // namespace tvl
