// Which surfel a point lies on, and what its distance is worth.
#pragma once

#include "tvl/registration/laser_terms.h"
#include "tvl/registration/surfel_map.h"

namespace tvl {

// Errors of a measured point, one standard deviation each.
struct MatchNoise {
  double sensor_sigma_m = 0.03;    // across a surface: range noise and beam bias
  double beam_sigma_rad = 0.0014;  // of a beam's elevation
  double edge_sigma_m = 0.10;      // across an edge
};

// Points (p_lidar, m) moved by T_world_lidar to their nearest surfels; those further than gate_m
// from the plane are left out. `source` is the index of the point. Thread-safe.
std::vector<PlaneMatch> MatchPlanes(const std::vector<Eigen::Vector3f>& points,
                                    const SurfelMap& map, const Rigid3d& T_world_lidar,
                                    double gate_m, const MatchNoise& noise,
                                    const Executor& executor);

// As MatchPlanes, for lines.
std::vector<LineMatch> MatchLines(const std::vector<Eigen::Vector3f>& points, const SurfelMap& map,
                                  const Rigid3d& T_world_lidar, double gate_m,
                                  const MatchNoise& noise);

}  // namespace tvl
