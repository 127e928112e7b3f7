#include "tvl/optim/pose_solver.h"

#include <gtest/gtest.h>

#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"

namespace tvl {
namespace {

// Point-to-point alignment with known correspondences.
class Alignment {
 public:
  explicit Alignment(const Rigid3d& T_true) {
    Rng rng(5);
    for (int i = 0; i < 40; ++i) {
      points_.emplace_back(10.0 * rng.Normal(), 10.0 * rng.Normal(), 3.0 * rng.Normal());
      targets_.push_back(T_true * points_.back());
    }
  }
  NormalEquations operator()(const Rigid3d& T) const {
    NormalEquations n;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d r = T * points_[i] - targets_[i];
      Eigen::Matrix<double, 3, 6> J;
      J << -T.R() * Hat(points_[i]), T.R();
      n.H += J.transpose() * J;
      n.b += J.transpose() * r;
      n.cost += 0.5 * r.squaredNorm();
    }
    return n;
  }

 private:
  std::vector<Eigen::Vector3d> points_, targets_;
};

TEST(SolvePose, FindsTheTruthFromFarAway) {
  Vector6d xi;
  xi << 0.8, -0.5, 1.2, 4.0, -3.0, 2.0;
  const Rigid3d T_true = Rigid3d::Exp(xi);
  PoseSolverOptions options;
  options.max_iterations = 30;
  const PoseSolution solution = SolvePose(Rigid3d(), Alignment(T_true), options);
  EXPECT_TRUE(solution.converged);
  EXPECT_THAT(solution.T, Rigid3dNear(T_true, 1e-8, 1e-7));
}

TEST(SolvePose, UnobservedDirectionsStayWhereTheyStarted) {
  const auto only_z = [](const Rigid3d& T) {
    NormalEquations n;
    RowVector6d J;
    J << 0.0, 0.0, 0.0, T.R().row(2);
    const double r = T.t().z() - 1.0;
    n.H = J.transpose() * J;
    n.b = J.transpose() * r;
    n.cost = 0.5 * r * r;
    return n;
  };
  const PoseSolution solution = SolvePose(Rigid3d::Translation(3.0, 2.0, 0.0), only_z, {});
  EXPECT_THAT(solution.T, Rigid3dNear(Rigid3d::Translation(3.0, 2.0, 1.0), 1e-9, 1e-6));
}

}  // namespace
}  // namespace tvl
