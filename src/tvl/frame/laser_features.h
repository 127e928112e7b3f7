// Laser features of one scan; what feature extraction hands on (paper 4.3).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tvl/frame/segmented_scan.h"

namespace tvl {

struct LaserFeature {
  Eigen::Vector3f p_lidar;  // m; at the instant it was measured
  float time_offset_s = 0;  // from the frame's stamp
  float curvature = 0;      // c of Eq. (1)
  float intensity = 0;
  uint16_t ring = 0;
  int32_t label = kLabelOutlier;  // as SegmentedScan::label
};

// F_s is a subset of F_ls, F_f of F_lf in the sense of the paper (here separate copies).
struct LaserFeatures {
  std::vector<LaserFeature> sharp;       // F_s: at most 2 a row and subregion
  std::vector<LaserFeature> flat;        // F_f: at most 4 a row and subregion
  std::vector<LaserFeature> less_sharp;  // F_ls
  std::vector<LaserFeature> less_flat;   // F_lf, voxel-thinned
};

}  // namespace tvl
