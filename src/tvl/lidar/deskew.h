// Moves the points of a sweep to one instant.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// Each point as if measured at the frame's stamp, the sensor moving at constant velocity:
// p_stamp = Exp(t / period * Log(T_prev_cur)) * p, with t its time offset from the stamp and
// T_prev_cur the sensor's motion over `period_s` (paper Eq. 3 with the stamp as reference:
// T_prev_cur maps the later sensor frame into the earlier one, so a point measured later, t > 0, is
// moved on). Interpolated from a table of poses: within 0.1 mm at 40 m/s and 1.5 rad/s, range 100
// m. Throws Error if the lengths differ or period_s <= 0.
std::vector<Eigen::Vector3f> DeskewPoints(const std::vector<Eigen::Vector3f>& points,
                                          const std::vector<float>& time_offset_s,
                                          const Rigid3d& T_prev_cur, double period_s);

}  // namespace tvl
