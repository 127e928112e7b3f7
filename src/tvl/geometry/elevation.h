// Raising points by an angle, as the vertical correction of a lidar does.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tvl {

// Each point turned about p x z by angle_rad: its elevation grows, its azimuth and range stay.
std::vector<Eigen::Vector3f> RaiseElevation(const std::vector<Eigen::Vector3f>& points,
                                            double angle_rad);

}  // namespace tvl
