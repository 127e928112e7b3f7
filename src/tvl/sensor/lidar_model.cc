#include "tvl/sensor/lidar_model.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {

double LidarModel::LargestGap_rad() const {
  double gap = 0.0;
  for (size_t i = 1; i < beam_elevation_rad.size(); ++i) {
    gap = std::max(gap, beam_elevation_rad[i - 1] - beam_elevation_rad[i]);
  }
  return gap;
}

void LidarModel::Check() const {
  TVL_CHECK_INPUT(columns >= 64) << "lidar.columns: must be at least 64, is " << columns;
  TVL_CHECK_INPUT(sweep_s > 0.0) << "lidar.sweep_s: must be positive, is " << sweep_s;
  TVL_CHECK_INPUT(range_sigma_m > 0.0)
      << "lidar.range_sigma_m: must be positive, is " << range_sigma_m;
  TVL_CHECK_INPUT(min_range_m >= 0.0 && max_range_m > min_range_m)
      << "lidar.min_range_m, lidar.max_range_m: want 0 <= min < max, are " << min_range_m << ", "
      << max_range_m;
  TVL_CHECK_INPUT(std::abs(ring_start_azimuth_rad) < 3.1416)
      << "lidar.ring_start_azimuth_deg: want -180..180";
  TVL_CHECK_INPUT(std::is_sorted(beam_elevation_rad.rbegin(), beam_elevation_rad.rend()))
      << "lidar.beam_elevation_deg: must fall from the topmost beam to the lowest";
}

}  // namespace tvl
