// The whole pose graph at once (paper 6.3): reference for the incremental one, and the final polish
// of a run. Levenberg-Marquardt with a sparse Cholesky factorisation; the first pose is held.
#pragma once

#include <vector>

#include "tvl/map/pose_graph.h"
#include "tvl/pose_graph/loop_loss.h"

namespace tvl {

struct BatchPoseGraphOptions {
  // What happens to loops the others contradict. kDcs: solved from the given poses and, if that
  // leaves loops in doubt, once more from the largest set of loops that agree with each other along
  // the odometry; the lower cost wins. With a fifth of the loops false it lost none of the true
  // ones and kept none of the false (benchmarks/pose_graph.py compares the losses).
  LoopLoss loop_loss = LoopLoss::kDcs;
  // Squared whitened error beyond which a loop is doubted; 16.8 is exceeded by 1 % of true loops
  // (chi-square of 6).
  double loop_width_sq = 16.8;
  // kGnc only: factor by which the truncated loss sharpens from round to round; 1.4 in the
  // publication, 2 needs half the rounds.
  double gnc_step = 2.0;
  // Of one minimisation with fixed loop weights; the graphs of a drive need 4 or 5.
  int max_iterations = 30;
  // Converged when the cost falls by less than this share.
  double min_cost_decrease = 1e-9;

  // Throws InputError naming the field.
  void Check() const;
};

struct BatchPoseGraphResult {
  std::vector<Rigid3d> T_world;
  // What robust handling left of each loop: 1 fully believed, towards 0: contradicted. A loop
  // counts as kept above 0.5.
  std::vector<double> loop_weights;
  double cost = 0.0;   // 0.5 sum e^T information e over odometry, plus 0.5 sum rho over loops
  int iterations = 0;  // factorisations
  bool converged = false;
};

// Starts at graph.T_world. Throws InputError naming the constraint if one is unusable, and the
// first pose that nothing connects to pose 0.
BatchPoseGraphResult OptimizeBatch(const PoseGraph& graph, const BatchPoseGraphOptions& options);

// The same cost for any poses.
double PoseGraphCost(const PoseGraph& graph, const std::vector<Rigid3d>& T_world, LoopLoss loss,
                     double loop_width_sq);

}  // namespace tvl
