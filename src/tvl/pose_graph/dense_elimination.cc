#include "tvl/pose_graph/dense_elimination.h"

#include <Eigen/Cholesky>

namespace tvl {

bool EliminateBlocks(int pivots, Eigen::MatrixXd* front) {
  using Block = Eigen::Matrix<double, 6, 6>;
  const Eigen::Index rows = front->rows(), columns = front->cols();
  for (Eigen::Index k = 0; k < 6 * pivots; k += 6) {
    const Block diagonal = front->block<6, 6>(k, k);
    const Eigen::LLT<Block> llt(diagonal);
    const Block L = llt.matrixL();
    // Not a number passes Eigen's own test.
    if (llt.info() != Eigen::Success || !L.allFinite()) return false;
    front->block<6, 6>(k, k) = L;
    const Eigen::Index below = rows - k - 6;
    auto panel = front->block<Eigen::Dynamic, 6>(k + 6, k, below, 6);
    // panel := panel L^-T, column by column.
    for (int c = 0; c < 6; ++c) {
      for (int b = 0; b < c; ++b) panel.col(c) -= L(c, b) * panel.col(b);
      panel.col(c) *= 1.0 / L(c, c);
    }
    for (Eigen::Index j = k + 6; j < columns; j += 6) {
      const Block at_j = front->block<6, 6>(j, k);
      front->block<Eigen::Dynamic, 6>(j, j, rows - j, 6).noalias() -=
          front->block<Eigen::Dynamic, 6>(j, k, rows - j, 6).lazyProduct(at_j.transpose());
    }
  }
  return true;
}

}  // namespace tvl
