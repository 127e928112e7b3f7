// In which order variables are eliminated and which of them belong together: the symbolic half of
// a sparse factorisation. Variables are numbered 0 .. size-1 here.
#pragma once

#include <vector>

namespace tvl {

// Sets of variables that meet in one term of the cost, one after another.
struct VariableGroups {
  std::vector<int> members;
  std::vector<int> ends;  // end of each group in `members`

  void Add(int variable) { members.push_back(variable); }
  void Close() { ends.push_back(static_cast<int>(members.size())); }
};

// The variables in an order that keeps the fill small (approximate minimum degree), those of `last`
// at the end in the order given: what is new will be touched again soon, so it stays near the root.
std::vector<int> EliminationOrder(int size, const VariableGroups& groups,
                                  const std::vector<int>& last);

// Variables that are eliminated together, given the same others: p(frontals | separator).
struct SymbolicClique {
  std::vector<int> variables;  // frontals, then the separator; in order of elimination
  int frontals = 0;            // how many of them
  int parent = -1;             // index of the clique that holds the separator, -1: a root
};

// The cliques of eliminating `order`, parents before children. A variable joins its parent's clique
// if that stores at most `slack` blocks of zeros for it: fewer, larger cliques are faster.
std::vector<SymbolicClique> EliminateSymbolically(const VariableGroups& groups,
                                                  const std::vector<int>& order, int slack);

}  // namespace tvl
