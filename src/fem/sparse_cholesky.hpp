#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/matrix.hpp"

/// Sparse Cholesky factors of matrices of 3x3 blocks, by Eigen: the only home of Eigen in the library, as a
/// private detail of its build.
namespace palpate::fem {

/// Rows in the order of approximate minimum degree (Amestoy, Davis & Duff 1996), the first to go first.
/// \param begin,columns  of each row the columns that are not zero, both ways
std::vector<Index> minimum_degree_order(std::span<const Index> begin, std::span<const Index> columns);

/// Blocks below the diagonal in each column of the factor of a matrix of this pattern, taken in this order.
/// O(blocks of the factor).
std::vector<std::uint32_t> factor_counts(std::span<const Index> begin, std::span<const Index> columns,
                                         std::span<const Index> order);

/// A block of the lower triangle, in the order of the factor; those of one place add up.
struct BlockEntry {
  Index row = 0;
  Index column = 0;
  Matrix3 block;
};
using BlockEntries = std::vector<BlockEntry>;

/// Column by column; blocks are stored column by column, nine values.
struct BlockFactor {
  std::vector<std::uint32_t> column_begin;
  std::vector<std::uint32_t> rows;
  std::vector<float> blocks;
  std::vector<float> inverses;  ///< of the blocks on the diagonal
};

/// L of A = L L^T, computed in double. Throws Error where A is not positive definite to rounding.
BlockFactor block_cholesky(Index size, std::span<const BlockEntry> entries);

}  // namespace palpate::fem
