// Elimination of the first variables of a dense quadratic form, in blocks of six.
#pragma once

#include <Eigen/Core>

namespace tvl {

// `front`: 6 n columns, at least as many rows (more are right-hand sides); lower triangle, column
// by column. The first `pivots` blocks of columns become the Cholesky factor, with the rows below
// them divided by it; the rest becomes the Schur complement. Returns false if a pivot is not
// positive definite; the front is then useless.
[[nodiscard]] bool EliminateBlocks(int pivots, Eigen::MatrixXd* front);

}  // namespace tvl
