#include "tvl/pose_graph/elimination.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

#include "tvl/base/index.h"

namespace tvl {
namespace {

// Calls f(begin, end) for each group.
template <typename F>
void ForEachGroup(const VariableGroups& groups, const F& f) {
  int begin = 0;
  for (const int end : groups.ends) {
    f(groups.members.data() + begin, groups.members.data() + end);
    begin = end;
  }
}

// Structure of the columns of the factor, by position in the order: which later positions each
// position is linked to when its turn comes. Sorted; the first one is its parent in the tree.
std::vector<std::vector<int>> ColumnStructures(const VariableGroups& groups,
                                               const std::vector<int>& position) {
  std::vector<std::vector<int>> columns(position.size());
  ForEachGroup(groups, [&](const int* begin, const int* end) {
    int first = static_cast<int>(position.size());
    for (const int* v = begin; v != end; ++v) first = std::min(first, position[Index(*v)]);
    for (const int* v = begin; v != end; ++v) {
      if (position[Index(*v)] != first) columns[Index(first)].push_back(position[Index(*v)]);
    }
  });
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    if (column.size() < 2) continue;
    // What is left of the column links its members: the first of them inherits the others.
    auto& parent = columns[Index(column.front())];
    parent.insert(parent.end(), column.begin() + 1, column.end());
  }
  return columns;
}

}  // namespace

std::vector<int> EliminationOrder(int size, const VariableGroups& groups,
                                  const std::vector<int>& last) {
  std::vector<char> is_last(Index(size), 0);
  for (const int v : last) is_last[Index(v)] = 1;
  std::vector<Eigen::Triplet<double, int>> links;
  // Eigen sorts out variables without an entry on the diagonal.
  for (int v = 0; v < size; ++v) links.emplace_back(v, v, 1.0);
  ForEachGroup(groups, [&](const int* begin, const int* end) {
    for (const int* a = begin; a != end; ++a) {
      for (const int* b = begin; b != a; ++b) {
        if (!is_last[Index(*a)] && !is_last[Index(*b)]) links.emplace_back(*a, *b, 1.0);
      }
    }
  });
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> pattern(size, size);
  pattern.setFromTriplets(links.begin(), links.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  std::vector<int> order;
  order.reserve(Index(size));
  for (const int v : permutation.indices()) {
    if (!is_last[Index(v)]) order.push_back(v);
  }
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

std::vector<SymbolicClique> EliminateSymbolically(const VariableGroups& groups,
                                                  const std::vector<int>& order, int slack) {
  std::vector<int> position(order.size()), clique_at(order.size());
  for (size_t k = 0; k < order.size(); ++k) position[Index(order[k])] = static_cast<int>(k);
  const std::vector<std::vector<int>> columns = ColumnStructures(groups, position);
  std::vector<SymbolicClique> cliques;
  for (size_t k = order.size(); k-- > 0;) {
    const std::vector<int>& column = columns[k];
    const int parent = column.empty() ? -1 : clique_at[Index(column.front())];
    if (parent >= 0 && cliques[Index(parent)].variables.size() <= column.size() + Index(slack)) {
      // Appended here, turned round below: frontals come first to last.
      cliques[Index(parent)].variables.push_back(order[k]);
      ++cliques[Index(parent)].frontals;
      clique_at[k] = parent;
      continue;
    }
    SymbolicClique clique;
    for (auto at = column.rbegin(); at != column.rend(); ++at) {
      clique.variables.push_back(order[Index(*at)]);
    }
    clique.variables.push_back(order[k]);
    clique.frontals = 1;
    clique.parent = parent;
    clique_at[k] = static_cast<int>(cliques.size());
    cliques.push_back(std::move(clique));
  }
  for (SymbolicClique& clique : cliques) {
    std::reverse(clique.variables.begin(), clique.variables.end());
  }
  return cliques;
}

}  // namespace tvl
