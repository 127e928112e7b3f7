#include "tvl/slam/loop_consistency.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace tvl {
namespace {

double Chi2(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

// Of the odometry over `length_m` of path.
Matrix6d OdometryCovariance(double length_m, const LoopConsistencyOptions& options) {
  const double rotation = options.support_rotation_rad_per_m * length_m;
  const double translation = options.support_translation_share * length_m;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(rotation * rotation);
  // A rotation somewhere on the way moves its end by up to the length.
  covariance.diagonal().tail<3>().setConstant(translation * translation +
                                              0.25 * rotation * rotation * length_m * length_m);
  return covariance;
}

Rigid3d Between(const std::vector<Rigid3d>& T_odom_lidar, int from, int to) {
  return T_odom_lidar[static_cast<size_t>(from)].Inverse() * T_odom_lidar[static_cast<size_t>(to)];
}

double PathBetween(const std::vector<double>& path_m, int a, int b) {
  return std::abs(path_m[static_cast<size_t>(a)] - path_m[static_cast<size_t>(b)]);
}

// Covariance `c` of a transform T in T * S, as seen behind S.
Matrix6d Behind(const Matrix6d& c, const Rigid3d& S) {
  const Matrix6d adjoint = S.Inverse().Adjoint();
  return adjoint * c * adjoint.transpose();
}

}  // namespace

double GraphChi2(const MeasuredLoop& loop, const Rigid3d& T_history_current_graph,
                 const Matrix6d& graph_covariance, double linked_path_m,
                 const LoopConsistencyOptions& options) {
  const Vector6d error = (T_history_current_graph.Inverse() * loop.T_history_current).Log();
  Matrix6d covariance = options.graph_inflation * graph_covariance + loop.covariance;
  const double drift_m = options.drift_share * linked_path_m;
  covariance.diagonal().tail<3>().array() += drift_m * drift_m;
  return Chi2(error, covariance);
}

double PairwiseChi2(const MeasuredLoop& a, const MeasuredLoop& b,
                    const std::vector<Rigid3d>& T_odom_lidar, const std::vector<double>& path_m,
                    const LoopConsistencyOptions& options) {
  // a.history -> b.history -> b.current -> a.current against a.
  const Rigid3d T_ha_hb = Between(T_odom_lidar, a.history, b.history);
  const Rigid3d T_cb_ca = Between(T_odom_lidar, b.current, a.current);
  const Rigid3d T_hb_ca = b.T_history_current * T_cb_ca;
  const Vector6d error = ((T_ha_hb * T_hb_ca).Inverse() * a.T_history_current).Log();
  const double history_m = PathBetween(path_m, a.history, b.history);
  const double current_m = PathBetween(path_m, a.current, b.current);
  const Matrix6d covariance = Behind(OdometryCovariance(history_m, options), T_hb_ca) +
                              Behind(b.covariance, T_cb_ca) +
                              OdometryCovariance(current_m, options) + a.covariance;
  return Chi2(error, covariance);
}

std::vector<size_t> FindSupport(const MeasuredLoop& loop, const std::vector<MeasuredLoop>& others,
                                const std::vector<Rigid3d>& T_odom_lidar,
                                const std::vector<double>& path_m,
                                const LoopConsistencyOptions& options) {
  std::vector<size_t> support;
  std::vector<int> currents = {loop.current};
  const auto is_apart = [&](int current) {
    for (const int taken : currents) {
      if (PathBetween(path_m, taken, current) < options.min_support_gap_m) return false;
    }
    return true;
  };
  for (size_t i = 0; i < others.size(); ++i) {
    const MeasuredLoop& other = others[i];
    if (PathBetween(path_m, loop.current, other.current) > options.max_support_path_m ||
        PathBetween(path_m, loop.history, other.history) > options.max_support_path_m ||
        !is_apart(other.current)) {
      continue;
    }
    if (PairwiseChi2(loop, other, T_odom_lidar, path_m, options) > options.max_chi2) continue;
    support.push_back(i);
    currents.push_back(other.current);
  }
  return support;
}

}  // namespace tvl
