// The square-root information of a sparse least-squares problem as a tree of cliques that can be
// changed in part (Kaess et al. 2012, "iSAM2", from the paper's section 6.3).
//
// Eliminating a clique's frontal variables gives p(frontals | separator) and leaves information
// about the separator, which is kept. A change of some terms changes only the cliques of their
// variables and those on the way to the root; all others hand in what they kept.
#pragma once

#include <vector>

#include "tvl/base/index.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/pose_graph/constraint_error.h"
#include "tvl/pose_graph/elimination.h"

namespace tvl {

// Quadratic terms over variables of six dimensions. Variables without terms must not be touched.
struct LinearTerm {
  int from = 0, to = 0;
  ConstraintBlocks blocks;
};
struct LinearGraph {
  std::vector<LinearTerm> terms;
  std::vector<std::vector<size_t>> terms_of;  // of each variable: indices of terms
  int held = 0;                               // this variable is known and never eliminated
};

class BayesTree {
 public:
  // Brings the tree up to date after terms of `touched` variables were added, changed or removed
  // (all variables of such terms). `newest` will be eliminated last. Returns how many variables
  // were eliminated anew. Throws Error if the information is not positive definite.
  int Update(const LinearGraph& graph, const std::vector<int>& touched,
             const std::vector<int>& newest);

  // Solves for the step from the linearisation point. Branches below variables that moved by less
  // than the tolerances are left as they are. Returns the variables that moved, in no order.
  std::vector<int> BackSubstitute(double tolerance_rad, double tolerance_m);

  // The step of a variable: right perturbation, [rotation, translation].
  const Vector6d& step(int variable) const { return steps_[Index(variable)]; }
  // For a variable whose linearisation point has been moved by its step.
  void ClearStep(int variable) { steps_[Index(variable)].setZero(); }

  // J Sigma J^T for y = J_a x_a + J_b x_b of two variables (the held one has no uncertainty), by a
  // forward substitution along their ways to the root.
  Matrix6d Covariance(int a, const Matrix6d& J_a, int b, const Matrix6d& J_b) const;

 private:
  struct Clique {
    std::vector<int> variables;  // frontals, then separator
    int frontals = 0;
    int parent = -1;
    std::vector<int> children;
    // Columns of variables, rows of variables and one for the right-hand side; lower triangle.
    // First 6 * frontals columns: the Cholesky factor L and, in the last row, d^T = (L^-1 rhs)^T.
    // The rest: the information that is left for the separator, with its right-hand side.
    Eigen::MatrixXd front;
    bool is_in_use = false, is_solved = false;
  };
  // What an update takes off the top of the tree.
  struct Top {
    std::vector<int> variables;  // to be eliminated anew, ascending
    std::vector<int> orphans;    // cliques that lost their parent
  };

  Top RemoveTop(const std::vector<int>& touched);
  VariableGroups GroupsOf(const LinearGraph& graph, const Top& top) const;
  std::vector<int> AddCliques(const std::vector<SymbolicClique>& symbolic, const Top& top);
  int NewClique();
  void AdoptOrphans(const std::vector<int>& orphans, const std::vector<int>& added);
  void EliminateClique(const LinearGraph& graph, int index);
  void AddTerms(const LinearGraph& graph, Clique* clique);
  void AddChild(const Clique& child, Clique* clique) const;
  bool SolveClique(Clique* clique, double tolerance_rad, double tolerance_m);
  std::vector<int> PathToRoot(int clique) const;

  std::vector<Clique> cliques_;
  std::vector<int> free_;       // unused entries of cliques_
  std::vector<int> clique_of_;  // of each variable: where it is frontal, -1: nowhere
  std::vector<Vector6d> steps_;
  std::vector<char> moved_;  // of each variable: in the running back-substitution
  std::vector<int> local_;   // of each variable: its place in the clique at hand, else -1
};

}  // namespace tvl
