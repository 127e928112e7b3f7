// Does a verified loop agree with what the graph knows, and with other loops? (Paper 6.3's ICP
// alone cannot tell parallel streets apart.)
#pragma once

#include <vector>

#include "tvl/slam/loop_options.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

// A measured loop: T_history_current with its covariance (right perturbation).
struct MeasuredLoop {
  int history = 0, current = 0;
  Rigid3d T_history_current;
  Matrix6d covariance = Matrix6d::Identity();
};

// Squared Mahalanobis distance (chi-square of 6) of a loop from the graph's estimate, given the
// graph's covariance of the same (right perturbation) and the path that links the two.
double GraphChi2(const MeasuredLoop& loop, const Rigid3d& T_history_current_graph,
                 const Matrix6d& graph_covariance, double linked_path_m,
                 const LoopConsistencyOptions& options);

// The same between two loops, going round by the odometry (T_odom_lidar and path_m of all
// keyframes): the pairwise consistency of Mangelson et al. (2018).
double PairwiseChi2(const MeasuredLoop& a, const MeasuredLoop& b,
                    const std::vector<Rigid3d>& T_odom_lidar, const std::vector<double>& path_m,
                    const LoopConsistencyOptions& options);

// Indices of the loops in `others` that support `loop`.
std::vector<size_t> FindSupport(const MeasuredLoop& loop, const std::vector<MeasuredLoop>& others,
                                const std::vector<Rigid3d>& T_odom_lidar,
                                const std::vector<double>& path_m,
                                const LoopConsistencyOptions& options);

}  // namespace tvl
