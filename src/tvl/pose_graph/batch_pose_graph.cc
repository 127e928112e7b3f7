#include "tvl/pose_graph/batch_pose_graph.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/index.h"
#include "tvl/pose_graph/constraint_error.h"
#include "tvl/pose_graph/loop_consistency.h"

namespace tvl {
namespace {

// Share of the diagonal. A long chain bends as a whole at 1e-9 of what its links hold: damping
// above that stalls, so plain Gauss-Newton comes first.
constexpr double kLeastDamping = 1e-10;

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Triplets = std::vector<Eigen::Triplet<double, int>>;

// What one round of the robust handling makes of a loop with squared error e_sq.
class LoopWeighing {
 public:
  LoopWeighing(LoopLoss loss, double width_sq) : loss_(loss), width_sq_(width_sq) {}
  // Truncated least squares, softened: the smaller mu, the closer to convex.
  static LoopWeighing Graduated(double mu, double width_sq) {
    LoopWeighing weighing(LoopLoss::kGnc, width_sq);
    weighing.mu_ = mu;
    return weighing;
  }
  // The surrogate of Yang et al. 2020, Eq. (12); mu_ = infinity is the truncated loss itself.
  RobustValue operator()(double e_sq) const {
    if (mu_ == 0.0) return EvaluateLoopLoss(loss_, e_sq, width_sq_);
    if (e_sq <= mu_ / (mu_ + 1.0) * width_sq_) return {e_sq, 1.0};
    if (e_sq >= (mu_ + 1.0) / mu_ * width_sq_) return {width_sq_, 0.0};
    const double mixed = std::sqrt(width_sq_ * e_sq * mu_ * (mu_ + 1.0));
    return {2.0 * mixed - mu_ * (width_sq_ + e_sq), mixed / e_sq - mu_};
  }

 private:
  LoopLoss loss_;
  double width_sq_;
  double mu_ = 0.0;
};

double Cost(const PoseGraph& graph, const std::vector<Rigid3d>& T_world,
            const LoopWeighing& weighing) {
  double sum = 0.0;
  for (const PoseConstraint& c : graph.odometry) {
    sum += SquaredError(c, T_world);
  }
  for (const PoseConstraint& c : graph.loops) {
    sum += weighing(SquaredError(c, T_world)).rho;
  }
  return 0.5 * sum;
}

std::vector<double> Weights(const PoseGraph& graph, const std::vector<Rigid3d>& T_world,
                            const LoopWeighing& weighing) {
  std::vector<double> weights;
  weights.reserve(graph.loops.size());
  for (const PoseConstraint& c : graph.loops) {
    weights.push_back(weighing(SquaredError(c, T_world)).weight);
  }
  return weights;
}

void AddBlock(const Matrix6d& block, int row, int column, Triplets* triplets) {
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) {
      if (6 * row + i >= 6 * column + j) {
        triplets->emplace_back(6 * row + i, 6 * column + j, block(i, j));
      }
    }
  }
}

// Lower triangle of the Gauss-Newton matrix and the gradient; pose k is variable k - 1.
struct NormalSystem {
  SparseMatrix H;
  Eigen::VectorXd b;
};

NormalSystem Linearize(const PoseGraph& graph, const std::vector<Rigid3d>& T_world,
                       const std::vector<double>& loop_weights) {
  const int variables = static_cast<int>(T_world.size()) - 1;
  NormalSystem system{SparseMatrix(6 * variables, 6 * variables),
                      Eigen::VectorXd::Zero(6 * variables)};
  Triplets triplets;
  triplets.reserve(78 * (graph.odometry.size() + graph.loops.size()));
  const auto add = [&](const PoseConstraint& c, double weight) {
    const ConstraintBlocks blocks =
        NormalBlocks(c, weight, T_world[Index(c.from)], T_world[Index(c.to)]);
    const int f = c.from - 1, t = c.to - 1;
    if (f >= 0) {
      AddBlock(blocks.H_ff, f, f, &triplets);
      system.b.segment<6>(6 * f) += blocks.b_f;
    }
    if (t >= 0) {
      AddBlock(blocks.H_tt, t, t, &triplets);
      system.b.segment<6>(6 * t) += blocks.b_t;
    }
    if (f >= 0 && t > f) AddBlock(blocks.H_ft.transpose(), t, f, &triplets);
    if (t >= 0 && f > t) AddBlock(blocks.H_ft, f, t, &triplets);
  };
  for (const PoseConstraint& c : graph.odometry) add(c, 1.0);
  for (size_t k = 0; k < graph.loops.size(); ++k) add(graph.loops[k], loop_weights[k]);
  system.H.setFromTriplets(triplets.begin(), triplets.end());
  return system;
}

std::vector<Rigid3d> Moved(const std::vector<Rigid3d>& T_world, const Eigen::VectorXd& step) {
  std::vector<Rigid3d> moved = T_world;
  for (size_t k = 1; k < moved.size(); ++k) {
    const Vector6d d = step.segment<6>(static_cast<Eigen::Index>(6 * (k - 1)));
    moved[k] = T_world[k] * Rigid3d::Exp(d);
  }
  return moved;
}

class Minimizer {
 public:
  Minimizer(const PoseGraph& graph, const BatchPoseGraphOptions& options)
      : graph_(graph), options_(options) {}

  // Levenberg-Marquardt, loop weights refreshed before each step; T_world and the counts of
  // `result` are carried on.
  void Run(const LoopWeighing& weighing, BatchPoseGraphResult* result) {
    double cost = Cost(graph_, result->T_world, weighing), damping = 0.0;
    result->converged = false;
    for (int i = 0; i < options_.max_iterations && !result->converged; ++i, ++result->iterations) {
      const std::vector<double> weights = Weights(graph_, result->T_world, weighing);
      const NormalSystem system = Linearize(graph_, result->T_world, weights);
      std::vector<Rigid3d> next = Moved(result->T_world, Step(system, damping));
      const double next_cost = Cost(graph_, next, weighing);
      // Steps at the level of rounding may raise the cost by as much.
      result->converged = std::abs(cost - next_cost) <= options_.min_cost_decrease * cost;
      if (next_cost < cost) {
        cost = next_cost;
        result->T_world = std::move(next);
        damping = damping > kLeastDamping ? 0.01 * damping : 0.0;
      } else {
        damping = std::max(kLeastDamping, 100.0 * damping);
      }
    }
  }

 private:
  Eigen::VectorXd Step(const NormalSystem& system, double damping) {
    SparseMatrix H = system.H;
    H.diagonal() *= 1.0 + damping;
    if (!is_analyzed_) solver_.analyzePattern(H);
    is_analyzed_ = true;
    solver_.factorize(H);
    TVL_CHECK(solver_.info() == Eigen::Success) << "the information is not positive definite";
    return solver_.solve(-system.b);
  }

  const PoseGraph& graph_;
  const BatchPoseGraphOptions& options_;
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> solver_;
  bool is_analyzed_ = false;
};

// Graduated non-convexity: from nearly least squares to the truncated loss.
void RunGraduated(const PoseGraph& graph, const BatchPoseGraphOptions& options,
                  Minimizer* minimizer, BatchPoseGraphResult* result) {
  minimizer->Run({LoopLoss::kNone, options.loop_width_sq}, result);
  double worst_sq = 0.0;
  for (const PoseConstraint& c : graph.loops) {
    worst_sq = std::max(worst_sq, SquaredError(c, result->T_world));
  }
  if (worst_sq <= options.loop_width_sq) return;
  // Yang et al. 2020, remark 5; beyond 1e3 the surrogate is the truncated loss to 0.1 %.
  double mu = options.loop_width_sq / std::max(2.0 * worst_sq - options.loop_width_sq, 1e-9);
  for (; mu < 1e3; mu *= options.gnc_step) {
    minimizer->Run(LoopWeighing::Graduated(mu, options.loop_width_sq), result);
  }
}

void CheckConnected(const PoseGraph& graph) {
  std::vector<std::vector<int>> neighbours(graph.T_world.size());
  for (const auto* constraints : {&graph.odometry, &graph.loops}) {
    for (const PoseConstraint& c : *constraints) {
      neighbours[Index(c.from)].push_back(c.to);
      neighbours[Index(c.to)].push_back(c.from);
    }
  }
  std::vector<char> is_reached(graph.T_world.size(), 0);
  std::vector<int> stack{0};
  is_reached[0] = 1;
  while (!stack.empty()) {
    const int pose = stack.back();
    stack.pop_back();
    for (const int next : neighbours[Index(pose)]) {
      char& is_next_reached = is_reached[Index(next)];
      if (!is_next_reached) stack.push_back(next);
      is_next_reached = 1;
    }
  }
  const auto missing = std::find(is_reached.begin(), is_reached.end(), 0);
  TVL_CHECK_INPUT(missing == is_reached.end())
      << "nothing connects pose " << missing - is_reached.begin() << " to pose 0";
}

bool IsChain(const std::vector<PoseConstraint>& odometry, size_t poses) {
  if (odometry.size() + 1 != poses) return false;
  for (size_t k = 0; k < odometry.size(); ++k) {
    const int from = static_cast<int>(k);
    if (odometry[k].from != from || odometry[k].to != from + 1) return false;
  }
  return true;
}

// Comparing each loop with each takes 0.3 s for so many, and 15 s for 3,600. They come in rows.
constexpr size_t kMaxCompared = 500;

std::vector<PoseConstraint> Thinned(const std::vector<PoseConstraint>& loops, size_t count) {
  const size_t step = (loops.size() + count - 1) / count;
  std::vector<PoseConstraint> some;
  for (size_t i = 0; i < loops.size(); i += step) some.push_back(loops[i]);
  return some;
}

// Poses by odometry and the loops that agree with each other along it, none of the others.
BatchPoseGraphResult SolveConsistentLoops(const PoseGraph& graph,
                                          const BatchPoseGraphOptions& options) {
  OdometryChain chain;
  PoseGraph agreed{{graph.T_world.front()}, graph.odometry, {}};
  for (const PoseConstraint& c : graph.odometry) {
    chain.Add(c);
    agreed.T_world.push_back(agreed.T_world.back() * c.T_from_to);
  }
  const std::vector<PoseConstraint> some = Thinned(graph.loops, kMaxCompared);
  for (const int loop : ConsistentSet(chain, some, options.loop_width_sq)) {
    agreed.loops.push_back(some[Index(loop)]);
  }
  BatchPoseGraphResult result;
  result.T_world = agreed.T_world;
  Minimizer(agreed, options).Run({LoopLoss::kNone, options.loop_width_sq}, &result);
  return result;
}

BatchPoseGraphResult Finished(const PoseGraph& graph, const LoopWeighing& weighing,
                              BatchPoseGraphResult result) {
  result.loop_weights = Weights(graph, result.T_world, weighing);
  result.cost = Cost(graph, result.T_world, weighing);
  return result;
}

}  // namespace

void BatchPoseGraphOptions::Check() const {
  TVL_CHECK_INPUT(loop_width_sq > 0.0) << "loop_width_sq must be positive";
  TVL_CHECK_INPUT(gnc_step > 1.0) << "gnc_step must be above 1";
  TVL_CHECK_INPUT(max_iterations >= 1) << "max_iterations must be at least 1";
  TVL_CHECK_INPUT(min_cost_decrease >= 0.0) << "min_cost_decrease must not be negative";
}

double PoseGraphCost(const PoseGraph& graph, const std::vector<Rigid3d>& T_world, LoopLoss loss,
                     double loop_width_sq) {
  return Cost(graph, T_world, {loss, loop_width_sq});
}

BatchPoseGraphResult OptimizeBatch(const PoseGraph& graph, const BatchPoseGraphOptions& options) {
  options.Check();
  const int poses = static_cast<int>(graph.T_world.size());
  for (const PoseConstraint& c : graph.odometry) CheckConstraint(c, poses, "odometry");
  for (const PoseConstraint& c : graph.loops) CheckConstraint(c, poses, "loop");
  BatchPoseGraphResult result;
  result.T_world = graph.T_world;
  if (poses < 2) return result;
  CheckConnected(graph);
  Minimizer minimizer(graph, options);
  if (options.loop_loss == LoopLoss::kGnc) RunGraduated(graph, options, &minimizer, &result);
  const LoopWeighing weighing(options.loop_loss, options.loop_width_sq);
  minimizer.Run(weighing, &result);
  result = Finished(graph, weighing, std::move(result));

  const bool has_doubts = std::any_of(result.loop_weights.begin(), result.loop_weights.end(),
                                      [](double weight) { return weight <= 0.5; });
  if (options.loop_loss != LoopLoss::kDcs || !has_doubts ||
      !IsChain(graph.odometry, graph.T_world.size())) {
    return result;
  }
  BatchPoseGraphResult other = SolveConsistentLoops(graph, options);
  minimizer.Run(weighing, &other);
  other.iterations += result.iterations;
  other = Finished(graph, weighing, std::move(other));
  return other.cost < result.cost ? other : result;
}

}  // namespace tvl
