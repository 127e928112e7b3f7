// The motion during one revolution (paper Eq. 3): where the lidar was when a point was measured.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// Times are cut into bins. Bin i stands for s = 0.5 + (i + 0.5) / bins in T_k_i = s (x) T_k_k1; one
// bin stands for s = 1: compensated scans, and images.
struct SweepBins {
  int bins = 1;

  static SweepBins Compensated() { return {1}; }
  // 128 bins of a 0.1 s sweep: the rest within a bin is taken to its middle by the caller.
  static SweepBins Raw() { return {128}; }
  double Share(int bin) const { return bins == 1 ? 1.0 : 0.5 + (bin + 0.5) / bins; }
  // Bin of a point measured time_offset_s from the stamp, with period_s between stamps.
  int BinOf(double time_offset_s, double period_s) const;
};

// T_k_i and the Jacobian from a right perturbation of T_k_k1 to one of T_k_i, for every bin.
struct SweepMotion {
  struct Bin {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
    Matrix6d J;
  };
  SweepMotion(const SweepBins& bins, const Rigid3d& T_k_k1);
  std::vector<Bin> bins;
};

}  // namespace tvl
