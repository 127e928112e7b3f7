#include "tvl/pose_graph/loop_consistency.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "tvl/base/check.h"

namespace tvl {
namespace {

Matrix6d Carried(const Matrix6d& covariance, const Rigid3d& T) {
  const Matrix6d ad = T.Adjoint();
  return ad * covariance * ad.transpose();
}

// Which loops agree with which.
class AgreementGraph {
 public:
  AgreementGraph(const OdometryChain& odometry, const std::vector<PoseConstraint>& loops,
                 double max_error_sq)
      : agrees_(loops.size(), std::vector<char>(loops.size(), 0)), degree_(loops.size(), 0) {
    for (size_t a = 0; a < loops.size(); ++a) {
      for (size_t b = 0; b < a; ++b) {
        if (!(CycleErrorSq(odometry, loops[a], loops[b]) <= max_error_sq)) continue;
        agrees_[a][b] = agrees_[b][a] = 1;
        ++degree_[a];
        ++degree_[b];
      }
    }
  }

  // Loops by falling number of others they agree with.
  std::vector<int> BestConnectedFirst() const {
    std::vector<int> order(degree_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return degree(a) > degree(b); });
    return order;
  }

  // Takes loops in the order given if they agree with `start` and all taken before.
  std::vector<int> GrowFrom(int start, const std::vector<int>& order) const {
    std::vector<int> set{start};
    for (const int loop : order) {
      const std::vector<char>& agrees_with = agrees_[Index(loop)];
      const bool agrees =
          std::all_of(set.begin(), set.end(), [&](int other) { return agrees_with[Index(other)]; });
      if (loop != start && agrees) set.push_back(loop);
    }
    return set;
  }

  int degree(int loop) const { return degree_[Index(loop)]; }

 private:
  std::vector<std::vector<char>> agrees_;
  std::vector<int> degree_;
};

}  // namespace

OdometryChain::OdometryChain() : T_first_{Rigid3d()}, covariance_{Matrix6d::Zero()} {}

void OdometryChain::Add(const PoseConstraint& odometry) {
  TVL_CHECK(odometry.from == size() - 1 && odometry.to == size())
      << "odometry from pose " << odometry.from << " to pose " << odometry.to << " after pose "
      << size() - 1;
  T_first_.push_back(T_first_.back() * odometry.T_from_to);
  const Matrix6d step = odometry.information.llt().solve(Matrix6d::Identity());
  covariance_.push_back(covariance_.back() + Carried(step, T_first_.back()));
}

OdometryChain::Relative OdometryChain::Between(int i, int j) const {
  TVL_CHECK(i >= 0 && i < size() && j >= 0 && j < size())
      << "odometry chain: poses " << i << ", " << j << " of " << size();
  return {T_first(i).Inverse() * T_first(j), Carried(Drift(i, j), T_first(j).Inverse())};
}

Matrix6d OdometryChain::Drift(int i, int j) const {
  if (i == j) return Matrix6d::Zero();
  return covariance_[Index(std::max(i, j))] - covariance_[Index(std::min(i, j))];
}

double CycleErrorSq(const OdometryChain& odometry, const PoseConstraint& a,
                    const PoseConstraint& b) {
  // a.from -> b.from -> (loop b) -> b.to -> a.to, against loop a; all in the frame of a.to.
  const Rigid3d T_start = odometry.Between(a.from, b.from).T_i_j;
  const Rigid3d T_end = odometry.Between(b.to, a.to).T_i_j;
  const Rigid3d T_b_end = b.T_from_to * T_end;
  const Vector6d e = (a.T_from_to.Inverse() * (T_start * T_b_end)).Log();
  // Drift in the frame of the first pose, carried to that of a.to; minus: driven backwards.
  const Matrix6d by_start = (a.from <= b.from ? 1.0 : -1.0) *
                            (T_b_end.Inverse() * odometry.T_first(b.from).Inverse()).Adjoint();
  const Matrix6d by_end = (b.to <= a.to ? 1.0 : -1.0) * odometry.T_first(a.to).Inverse().Adjoint();
  Matrix6d covariance = a.information.llt().solve(Matrix6d::Identity()) +
                        Carried(b.information.llt().solve(Matrix6d::Identity()), T_end.Inverse()) +
                        by_start * odometry.Drift(a.from, b.from) * by_start.transpose() +
                        by_end * odometry.Drift(b.to, a.to) * by_end.transpose();
  // What is driven on both ways errs on both alike: forth and back it nearly cancels.
  const int begin = std::max(std::min(a.from, b.from), std::min(a.to, b.to));
  const int end = std::min(std::max(a.from, b.from), std::max(a.to, b.to));
  if (begin < end) {
    const Matrix6d both = by_start * odometry.Drift(begin, end) * by_end.transpose();
    covariance += both + both.transpose();
  }
  return e.dot(covariance.llt().solve(e));
}

std::vector<int> ConsistentSet(const OdometryChain& odometry,
                               const std::vector<PoseConstraint>& loops, double max_error_sq) {
  const AgreementGraph graph(odometry, loops, max_error_sq);
  const std::vector<int> order = graph.BestConnectedFirst();
  std::vector<int> best;
  for (const int start : order) {
    if (graph.degree(start) + 1 <= static_cast<int>(best.size())) break;
    std::vector<int> set = graph.GrowFrom(start, order);
    if (set.size() > best.size()) best = std::move(set);
  }
  std::sort(best.begin(), best.end());
  return best;
}

}  // namespace tvl
