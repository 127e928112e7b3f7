// Random pose graphs for tests.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/pose_graph/constraint_error.h"

namespace tvl {

inline Rigid3d RandomMotion(Rng* rng, double rotation_rad, double translation_m) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? rotation_rad : translation_m) * rng->Normal();
  return Rigid3d::Exp(xi);
}

// Symmetric, positive definite, with correlations; standard deviations about those given.
inline Matrix6d RandomInformation(Rng* rng, double rotation_rad, double translation_m) {
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = 0.15 * rng->Normal() + (i % 7 == 0 ? 1.0 : 0.0);
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1.0 / rotation_rad),
      Eigen::Vector3d::Constant(1.0 / translation_m);
  const Matrix6d information = scale.asDiagonal() * (root * root.transpose()) * scale.asDiagonal();
  return 0.5 * (information + information.transpose());
}

// A winding path of `poses` poses with noisy odometry and `loops` loops between random ones.
inline PoseGraph RandomGraph(uint64_t seed, int poses, int loops) {
  Rng rng(seed);
  PoseGraph graph;
  std::vector<Rigid3d> truth{RandomMotion(&rng, 1.0, 10.0)};
  graph.T_world.push_back(truth[0]);
  for (int k = 1; k < poses; ++k) {
    truth.push_back(truth.back() * Rigid3d::Translation(1.0, 0.0, 0.0) *
                    RandomMotion(&rng, 0.2, 0.1));
    const Rigid3d Z = truth[k - 1].Inverse() * truth[k] * RandomMotion(&rng, 0.01, 0.05);
    graph.odometry.push_back({k - 1, k, Z, RandomInformation(&rng, 0.01, 0.05)});
    graph.T_world.push_back(graph.T_world.back() * Z);
  }
  for (int k = 0; k < loops; ++k) {
    const int to = 1 + static_cast<int>(rng.Integer(poses - 1));
    const int from = static_cast<int>(rng.Integer(to));
    const Rigid3d Z = truth[from].Inverse() * truth[to] * RandomMotion(&rng, 0.01, 0.05);
    graph.loops.push_back({from, to, Z, RandomInformation(&rng, 0.01, 0.05)});
  }
  return graph;
}

// Gauss-Newton matrix of all poses but the first, dense, by the graph's poses.
inline Eigen::MatrixXd DenseInformation(const PoseGraph& graph) {
  const auto n = static_cast<Eigen::Index>(6 * graph.T_world.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  for (const auto* constraints : {&graph.odometry, &graph.loops}) {
    for (const PoseConstraint& c : *constraints) {
      const ConstraintJacobians lin =
          LinearizeConstraint(c, graph.T_world[c.from], graph.T_world[c.to]);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, n);
      J.middleCols<6>(6 * c.from) = lin.J_from;
      J.middleCols<6>(6 * c.to) = lin.J_to;
      H += J.transpose() * c.information * J;
    }
  }
  return H.bottomRightCorner(n - 6, n - 6);
}

}  // namespace tvl
