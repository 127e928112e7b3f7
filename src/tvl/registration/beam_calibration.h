// Estimates small errors of single laser beams while driving: an elevation and a range offset for
// each ring, from the residuals of the map step.
//
// The same wall or stretch of road is seen by one beam after another as the vehicle passes. If the
// beams disagree, the scan keeps leaning on its own map and the trajectory bends, steadily: on
// simulated drives with 0.08 deg and 0.03 m of scatter between beams this is most of the drift.
// What all beams have in common cannot be told from the map (it is the profile's business): the
// offsets have zero mean.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/registration/laser_terms.h"

namespace tvl {

struct BeamCalibrationOptions {
  bool enabled = true;
  // What beams are off by before anything is known, one standard deviation.
  double prior_elevation_rad = 0.0014;  // 0.08 deg
  double prior_range_m = 0.03;
  // Residuals of neighbouring points and frames share their errors: they count for this share.
  double information_share = 0.05;
  // Frames after which an observation counts for 1/e: the map they were made against still held the
  // beams' old errors.
  double memory_frames = 200;
  int update_every = 5;  // frames between solutions
  void Check() const;
};

// Offsets to add to the elevation and the range of the points of a ring; empty: none.
struct BeamOffsets {
  std::vector<float> elevation_rad, range_m;
};

class BeamCalibration {
 public:
  BeamCalibration(int rings, const BeamCalibrationOptions& options);

  // Takes the plane matches of one frame at its final pose; `rings` holds the ring of each match.
  // Matches must have been made with points corrected by offsets().
  void Add(const std::vector<PlaneMatch>& matches, const std::vector<uint16_t>& rings,
           const Rigid3d& T_world_lidar, double kernel_sigmas);

  const BeamOffsets& offsets() const { return offsets_; }

 private:
  // Normal equations of one frame: its pose, the offsets, and between them.
  struct Sums {
    Matrix6d H_pose = 1e-6 * Matrix6d::Identity();
    Vector6d b_pose = Vector6d::Zero();
    Eigen::MatrixXd H_cross, A;
    Eigen::VectorXd b;
  };
  Sums SumUp(const std::vector<PlaneMatch>& matches, const std::vector<uint16_t>& rings,
             const Rigid3d& T_world_lidar, double kernel_sigmas) const;
  void Solve();

  int rings_;
  BeamCalibrationOptions options_;
  // Normal equations of the absolute offsets [elevation, range] of every ring, the frames' poses
  // marginalised out.
  Eigen::MatrixXd A_;
  Eigen::VectorXd c_;
  Eigen::VectorXd current_;  // the offsets in use
  BeamOffsets offsets_;
  int frames_ = 0;
};

// The points with the offsets of their rings.
void ApplyBeamOffsets(const BeamOffsets& offsets, const std::vector<uint16_t>& ring,
                      std::vector<Eigen::Vector3f>* points);

}  // namespace tvl
