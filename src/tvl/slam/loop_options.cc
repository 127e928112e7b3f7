#include "tvl/slam/loop_options.h"

#include "tvl/base/check.h"

namespace tvl {

void LoopConsistencyOptions::Check() const {
  TVL_CHECK_INPUT(max_chi2 > 0.0) << "loops.consistency.max_chi2: must be positive";
  TVL_CHECK_INPUT(drift_share >= 0.0 && drift_floor_m >= 0.0 && drift_rad_per_m >= 0.0)
      << "loops.consistency.drift_share, drift_floor_m, drift_rad_per_m: must not be negative";
  TVL_CHECK_INPUT(link_floor_m >= 0.0 && link_floor_rad >= 0.0)
      << "loops.consistency.link_floor_m, link_floor_rad: must not be negative";
  TVL_CHECK_INPUT(max_chi2_of_rows >= max_chi2)
      << "loops.consistency.max_chi2_of_rows: must be at least max_chi2";
  TVL_CHECK_INPUT(min_row_m >= 0.0) << "loops.consistency.min_row_m: must not be negative";
  TVL_CHECK_INPUT(linked_path_m >= 0.0) << "loops.consistency.linked_path_m: must not be negative";
  TVL_CHECK_INPUT(min_support >= 0) << "loops.consistency.min_support: must not be negative";
  TVL_CHECK_INPUT(max_support_path_m > min_support_gap_m && min_support_gap_m >= 0.0)
      << "loops.consistency: want max_support_path_m > min_support_gap_m >= 0";
  TVL_CHECK_INPUT(max_doubt_path_m >= 0.0)
      << "loops.consistency.max_doubt_path_m: must not be negative";
  TVL_CHECK_INPUT(min_support_share >= 0.0 && min_support_share <= 1.0)
      << "loops.consistency.min_support_share: must be in 0..1";
}

void LoopOptions::Check() const {
  TVL_CHECK_INPUT(lag_keyframes >= 0) << "loops.lag_keyframes: must not be negative";
  TVL_CHECK_INPUT(max_verifications >= 1) << "loops.max_verifications: must be at least 1";
  TVL_CHECK_INPUT(connected_path_m >= 0.0) << "loops.connected_path_m: must not be negative";
  separation.Check();
  drift.Check();
  visual.Check();
  vicinity.Check();
  lidar_descriptor.Check();
  lidar.Check();
  verification.Check();
  consistency.Check();
  graph.Check();
  polish.Check();
}

}  // namespace tvl
