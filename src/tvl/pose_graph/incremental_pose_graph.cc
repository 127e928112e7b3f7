#include "tvl/pose_graph/incremental_pose_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/index.h"
#include "tvl/pose_graph/constraint_error.h"

namespace tvl {
namespace {

// Changes among weights below this do not matter.
constexpr double kNegligibleWeight = 1e-3;

}  // namespace

void IncrementalPoseGraphOptions::Check() const {
  TVL_CHECK_INPUT(relinearize_rotation_rad > 0.0) << "relinearize_rotation_rad must be positive";
  TVL_CHECK_INPUT(relinearize_translation_m > 0.0) << "relinearize_translation_m must be positive";
  TVL_CHECK_INPUT(settle_rotation_rad >= 0.0 && settle_rotation_rad < relinearize_rotation_rad)
      << "settle_rotation_rad must lie between 0 and relinearize_rotation_rad";
  TVL_CHECK_INPUT(settle_translation_m >= 0.0 && settle_translation_m < relinearize_translation_m)
      << "settle_translation_m must lie between 0 and relinearize_translation_m";
  TVL_CHECK_INPUT(max_iterations >= 1) << "max_iterations must be at least 1";
  TVL_CHECK_INPUT(loop_width_sq > 0.0) << "loop_width_sq must be positive";
  TVL_CHECK_INPUT(max_innovation_sq > 0.0) << "max_innovation_sq must be positive";
  TVL_CHECK_INPUT(min_weight_change > 0.0) << "min_weight_change must be positive";
  TVL_CHECK_INPUT(loop_loss != LoopLoss::kGnc)
      << "loop_loss: truncated least squares need the batch optimiser";
}

IncrementalPoseGraph::IncrementalPoseGraph(const IncrementalPoseGraphOptions& options)
    : options_(options) {
  options_.Check();
}

void IncrementalPoseGraph::AddFirst(const Rigid3d& T_world) {
  TVL_CHECK(estimates_.empty()) << "the graph has a first pose already";
  linearized_at_.push_back(T_world);
  estimates_.push_back(T_world);
  graph_.terms_of.emplace_back();
}

PoseGraphUpdate IncrementalPoseGraph::AddKeyframe(const PoseConstraint& odometry) {
  TVL_CHECK(!estimates_.empty()) << "AddFirst comes first";
  TVL_CHECK(odometry.to == size()) << "the next pose is " << size() << ", not " << odometry.to;
  CheckConstraint(odometry, size() + 1, "odometry");
  const Rigid3d T_world = estimates_[Index(odometry.from)] * odometry.T_from_to;
  linearized_at_.push_back(T_world);
  estimates_.push_back(T_world);
  graph_.terms_of.emplace_back();
  AddTerm(odometry, 1.0);
  PoseGraphUpdate update;
  update.iterations = 1;
  update.eliminated = tree_.Update(graph_, {odometry.from, odometry.to}, {odometry.to});
  // Nothing is pulled anywhere by a pose that hangs on one other: only its own step is new.
  update.moved = static_cast<int>(
      tree_.BackSubstitute(options_.settle_rotation_rad, options_.settle_translation_m).size());
  estimates_.back() = linearized_at_.back() * Rigid3d::Exp(tree_.step(odometry.to));
  return update;
}

PoseGraphUpdate IncrementalPoseGraph::AddLoops(const std::vector<PoseConstraint>& loops) {
  for (const PoseConstraint& loop : loops) CheckConstraint(loop, size(), "loop");
  std::vector<int> touched;
  std::vector<double> weights;
  for (const PoseConstraint& loop : loops) {
    // After a long way every loop is far off: what counts is whether the graph is sure of that.
    const bool is_doubted =
        options_.loop_loss != LoopLoss::kNone && InnovationSq(loop) > options_.max_innovation_sq;
    weights.push_back(is_doubted ? 0.0 : 1.0);
  }
  for (size_t k = 0; k < loops.size(); ++k) {
    const PoseConstraint& loop = loops[k];
    loop_terms_.push_back(AddTerm(loop, weights[k]));
    is_loop_.back() = 1;
    touched.insert(touched.end(), {loop.from, loop.to});
  }
  return Solve(std::move(touched));
}

size_t IncrementalPoseGraph::AddTerm(const PoseConstraint& constraint, double weight) {
  const size_t term = constraints_.size();
  constraints_.push_back(constraint);
  weights_.push_back(weight);
  is_loop_.push_back(0);
  graph_.terms.push_back({constraint.from, constraint.to, {}});
  graph_.terms_of[Index(constraint.from)].push_back(term);
  graph_.terms_of[Index(constraint.to)].push_back(term);
  LinearizeTerm(term);
  return term;
}

void IncrementalPoseGraph::LinearizeTerm(size_t term) {
  const PoseConstraint& c = constraints_[term];
  graph_.terms[term].blocks =
      NormalBlocks(c, weights_[term], linearized_at_[Index(c.from)], linearized_at_[Index(c.to)]);
}

PoseGraphUpdate IncrementalPoseGraph::Solve(std::vector<int> touched) {
  PoseGraphUpdate update;
  const std::vector<int> newest = {size() - 1};
  for (; update.iterations < options_.max_iterations && !touched.empty(); ++update.iterations) {
    update.eliminated += tree_.Update(graph_, touched, newest);
    const std::vector<int> moved =
        tree_.BackSubstitute(options_.settle_rotation_rad, options_.settle_translation_m);
    for (const int v : moved) {
      estimates_[Index(v)] = linearized_at_[Index(v)] * Rigid3d::Exp(tree_.step(v));
    }
    update.moved = std::max(update.moved, static_cast<int>(moved.size()));
    if (update.iterations + 1 == options_.max_iterations) continue;
    touched = ReweighLoops();
    std::vector<int> bent = Relinearize();
    update.relinearized += static_cast<int>(bent.size());
    for (const int v : bent) {
      for (const size_t t : graph_.terms_of[Index(v)]) {
        const PoseConstraint& c = constraints_[t];
        LinearizeTerm(t);
        touched.insert(touched.end(), {c.from, c.to});
      }
    }
  }
  return update;
}

std::vector<int> IncrementalPoseGraph::Relinearize() {
  std::vector<int> bent;
  for (int v = 1; v < size(); ++v) {
    const Vector6d& step = tree_.step(v);
    if (step.head<3>().norm() > options_.relinearize_rotation_rad ||
        step.tail<3>().norm() > options_.relinearize_translation_m) {
      linearized_at_[Index(v)] = estimates_[Index(v)];
      tree_.ClearStep(v);
      bent.push_back(v);
    }
  }
  return bent;
}

std::vector<int> IncrementalPoseGraph::ReweighLoops() {
  std::vector<int> touched;
  for (int loop = 0; loop < loops(); ++loop) {
    const size_t term = loop_terms_[Index(loop)];
    const double e_sq = SquaredError(constraints_[term], estimates_);
    // A loop in doubt stays out until the graph agrees with it: half a weight would pull it there.
    if (weights_[term] == 0.0 && e_sq > options_.loop_width_sq) continue;
    const double weight = EvaluateLoopLoss(options_.loop_loss, e_sq, options_.loop_width_sq).weight;
    const double larger = std::max({weight, weights_[term], kNegligibleWeight});
    if (std::abs(weight - weights_[term]) < options_.min_weight_change * larger) continue;
    weights_[term] = weight;
    LinearizeTerm(term);
    touched.insert(touched.end(), {constraints_[term].from, constraints_[term].to});
  }
  return touched;
}

std::vector<double> IncrementalPoseGraph::LoopWeights() const {
  std::vector<double> weights;
  weights.reserve(loop_terms_.size());
  for (const size_t term : loop_terms_) weights.push_back(weights_[term]);
  return weights;
}

double IncrementalPoseGraph::Cost() const {
  double sum = 0.0;
  for (size_t term = 0; term < constraints_.size(); ++term) {
    const double e_sq = SquaredError(constraints_[term], estimates_);
    sum += is_loop_[term] ? EvaluateLoopLoss(options_.loop_loss, e_sq, options_.loop_width_sq).rho
                          : e_sq;
  }
  return 0.5 * sum;
}

PoseGraph IncrementalPoseGraph::Graph() const {
  PoseGraph graph;
  graph.T_world = estimates_;
  for (size_t term = 0; term < constraints_.size(); ++term) {
    (is_loop_[term] ? graph.loops : graph.odometry).push_back(constraints_[term]);
  }
  return graph;
}

double IncrementalPoseGraph::InnovationSq(const PoseConstraint& loop) const {
  CheckConstraint(loop, size(), "loop");
  const Vector6d e =
      ConstraintError(loop, estimates_[Index(loop.from)], estimates_[Index(loop.to)]);
  const Matrix6d covariance =
      RelativeCovariance(loop.from, loop.to) + loop.information.llt().solve(Matrix6d::Identity());
  return e.dot(covariance.llt().solve(e));
}

Matrix6d IncrementalPoseGraph::RelativeCovariance(int i, int j) const {
  TVL_CHECK(i >= 0 && i < size() && j >= 0 && j < size()) << "poses " << i << " and " << j;
  // T_ij Exp(x_j) with x_i carried to the right: Exp(-x_i) T_ij = T_ij Exp(-Ad(T_ij^-1) x_i).
  const Rigid3d T_j_i = linearized_at_[Index(j)].Inverse() * linearized_at_[Index(i)];
  return tree_.Covariance(i, -T_j_i.Adjoint(), j, Matrix6d::Identity());
}

}  // namespace tvl
