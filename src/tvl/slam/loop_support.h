// Does a verified loop agree with what the graph knows, and with other loops? (Registration alone,
// as in paper 6.3, cannot tell parallel streets apart.)
#pragma once

#include <vector>

#include "tvl/map/pose_graph.h"
#include "tvl/pose_graph/loop_consistency.h"
#include "tvl/slam/loop_options.h"

namespace tvl {

// Squared Mahalanobis distance (chi-square of 6) of a loop from the graph's estimate of the same,
// given the graph's covariance of it (right perturbation) and the path that links the two.
double GraphChi2(const PoseConstraint& loop, const Rigid3d& T_from_to_graph,
                 const Matrix6d& graph_covariance, double linked_path_m,
                 const LoopConsistencyOptions& options);

// How much larger the odometry's errors are, in variance, than its covariances say: 1 to 25.
// From the innovations (squared, whitened by the graph's own covariance, chi-square of 6 if that is
// right) of loops that ended a long way without any. Their upper median, since some loops may be
// false.
double OdometryVarianceFactor(std::vector<double> innovations_sq);

// The graph with the odometry believed so much less.
PoseGraph WithOdometryVariance(PoseGraph graph, double factor);

// Indices of the loops in `others` that support `loop`: they go round with it by the odometry
// (pairwise consistency), are near it on both passes, and their current keyframes are apart.
// path_m: driven up to each keyframe.
std::vector<size_t> FindSupport(const PoseConstraint& loop,
                                const std::vector<PoseConstraint>& others,
                                const OdometryChain& odometry, const std::vector<double>& path_m,
                                const LoopConsistencyOptions& options);

}  // namespace tvl
