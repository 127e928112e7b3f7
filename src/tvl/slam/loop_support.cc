#include "tvl/slam/loop_support.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tvl {

double GraphChi2(const PoseConstraint& loop, const Rigid3d& T_from_to_graph,
                 const Matrix6d& graph_covariance, double linked_path_m,
                 const LoopConsistencyOptions& options) {
  const Vector6d error = (T_from_to_graph.Inverse() * loop.T_from_to).Log();
  Matrix6d covariance = graph_covariance + loop.information.ldlt().solve(Matrix6d::Identity());
  const double floor_m =
      linked_path_m > options.linked_path_m ? options.drift_floor_m : options.link_floor_m;
  const double drift_m = std::max(floor_m, options.drift_share * linked_path_m);
  const double drift_rad =
      std::max(options.link_floor_rad, options.drift_rad_per_m * linked_path_m);
  covariance.diagonal().head<3>().array() += drift_rad * drift_rad;
  covariance.diagonal().tail<3>().array() += drift_m * drift_m;
  return error.dot(covariance.ldlt().solve(error));
}

double OdometryVarianceFactor(std::vector<double> innovations_sq) {
  constexpr double kMedianChi2Of6 = 5.348;
  // Five standard deviations. With a factor of a hundred a row of false loops, the first of a
  // drive, was kept against the true ones that followed.
  constexpr double kMaxFactor = 25.0;
  if (innovations_sq.empty()) return 1.0;
  const auto middle =
      innovations_sq.begin() + static_cast<std::ptrdiff_t>(innovations_sq.size() / 2);
  std::nth_element(innovations_sq.begin(), middle, innovations_sq.end());
  return std::clamp(*middle / kMedianChi2Of6, 1.0, kMaxFactor);
}

PoseGraph WithOdometryVariance(PoseGraph graph, double factor) {
  for (PoseConstraint& odometry : graph.odometry) odometry.information /= factor;
  return graph;
}

std::vector<size_t> FindSupport(const PoseConstraint& loop,
                                const std::vector<PoseConstraint>& others,
                                const OdometryChain& odometry, const std::vector<double>& path_m,
                                const LoopConsistencyOptions& options) {
  const auto apart_m = [&](int a, int b) {
    return std::abs(path_m[static_cast<size_t>(a)] - path_m[static_cast<size_t>(b)]);
  };
  std::vector<size_t> support;
  std::vector<int> currents = {loop.to};
  for (size_t i = 0; i < others.size(); ++i) {
    const PoseConstraint& other = others[i];
    const bool is_near = apart_m(loop.to, other.to) <= options.max_support_path_m &&
                         apart_m(loop.from, other.from) <= options.max_support_path_m;
    const bool is_new = std::all_of(currents.begin(), currents.end(), [&](int current) {
      return apart_m(current, other.to) >= options.min_support_gap_m;
    });
    if (!is_near || !is_new) continue;
    if (!(CycleErrorSq(odometry, loop, other) <= options.max_chi2)) continue;
    support.push_back(i);
    currents.push_back(other.to);
  }
  return support;
}

}  // namespace tvl
