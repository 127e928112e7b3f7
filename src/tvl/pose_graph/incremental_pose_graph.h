// The pose graph while it grows (paper 6.3): each keyframe and each loop changes only what it
// touches. In the spirit of iSAM2 (Kaess et al. 2012): a Bayes tree of which only the affected top
// is eliminated anew, linearisation points that move only where the estimate left them (fluid
// relinearisation), back-substitution only where something changes.
//
// A keyframe brings no news about the others: it costs the same however long the drive. A loop is
// iterated until the estimate lies within the thresholds of its linearisation points.
// Not thread-safe. Deterministic.
#pragma once

#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/map/pose_graph.h"
#include "tvl/pose_graph/bayes_tree.h"
#include "tvl/pose_graph/loop_loss.h"

namespace tvl {

struct IncrementalPoseGraphOptions {
  // A pose is relinearised when its estimate left the linearisation point by more than this.
  // Rotations bend the residuals: 0.005 rad makes an error of 1e-5 of the lengths involved.
  double relinearize_rotation_rad = 0.005;
  // Displacements do not bend them by themselves, only together with rotations.
  double relinearize_translation_m = 0.2;
  // Branches that move by less keep their old solution; the batch solution at the end settles it.
  double settle_rotation_rad = 1e-6;
  double settle_translation_m = 1e-4;
  // Times the linear problem is solved per call at most; the worst case of one call is this many
  // eliminations of the whole graph.
  int max_iterations = 4;
  // What happens to loops the others contradict, and beyond which squared whitened error: 16.8 is
  // exceeded by 1 % of true loops (chi-square of 6).
  LoopLoss loop_loss = LoopLoss::kDcs;
  double loop_width_sq = 16.8;
  // A new loop farther than this from what the graph knows (InnovationSq) is doubted: it waits with
  // weight 0 until the estimates come within loop_width_sq of it.
  // Exceeded by 0.1 % of true loops (chi-square of 6). Not used with LoopLoss::kNone.
  double max_innovation_sq = 22.5;
  // Loops whose weight changes by less than this share are not touched: each costs an update.
  double min_weight_change = 0.1;

  // Throws InputError naming the field.
  void Check() const;
};

// What an update took, to be reported.
struct PoseGraphUpdate {
  int iterations = 0;
  int eliminated = 0;    // variables eliminated anew, over all iterations
  int relinearized = 0;  // poses whose linearisation point moved, over all iterations
  int moved = 0;         // poses whose estimate changed, at most in one iteration
};

class IncrementalPoseGraph {
 public:
  // Throws InputError if the options are unusable.
  explicit IncrementalPoseGraph(const IncrementalPoseGraphOptions& options);

  // The first pose, index 0; it stays where it is. Before anything else, once.
  void AddFirst(const Rigid3d& T_world);
  // The next pose, from an earlier one (odometry.to = size()): its first estimate is composed.
  // Throws InputError naming the constraint if it is unusable.
  PoseGraphUpdate AddKeyframe(const PoseConstraint& odometry);
  // Loops between existing poses, all that were verified: doubted ones do no harm and count when
  // others come to agree with them. When several are in doubt, a false one may have come first and
  // the true ones are those that wait: the batch solution, which weighs them all, tells.
  PoseGraphUpdate AddLoops(const std::vector<PoseConstraint>& loops);

  int size() const { return static_cast<int>(estimates_.size()); }
  int loops() const { return static_cast<int>(loop_terms_.size()); }
  // T_world of every pose.
  const std::vector<Rigid3d>& estimates() const { return estimates_; }
  // What robust handling left of each loop, in the order they came: 1 fully believed, towards 0:
  // contradicted; 0: doubted from the start.
  std::vector<double> LoopWeights() const;
  // 0.5 sum e^T information e over odometry plus 0.5 sum rho over loops, at the estimates.
  double Cost() const;
  // Everything added, with the estimates: for the batch solution at the end.
  PoseGraph Graph() const;

  // How far a loop that is not in the graph is from what the graph knows: its error at the
  // estimates, squared and whitened by RelativeCovariance plus the loop's own covariance. For a
  // true loop chi-square of 6: 22.5 is exceeded by 0.1 % of them.
  double InnovationSq(const PoseConstraint& loop) const;

  // Covariance of T_i^-1 T_j by a right perturbation, [rotation, translation] in the frame of j:
  // what the graph knows about two of its poses, for judging a loop between them. Weights of loops
  // count, linearised where the graph was last.
  Matrix6d RelativeCovariance(int i, int j) const;

 private:
  size_t AddTerm(const PoseConstraint& constraint, double weight);
  void LinearizeTerm(size_t term);
  PoseGraphUpdate Solve(std::vector<int> touched);
  std::vector<int> Relinearize();
  std::vector<int> ReweighLoops();

  IncrementalPoseGraphOptions options_;
  std::vector<PoseConstraint> constraints_;  // of each term of graph_
  std::vector<double> weights_;
  std::vector<size_t> loop_terms_;  // of each loop: its term
  std::vector<char> is_loop_;       // of each term
  std::vector<Rigid3d> linearized_at_, estimates_;
  LinearGraph graph_;
  BayesTree tree_;
};

}  // namespace tvl
