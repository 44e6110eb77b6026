#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::fem {

/// A 6x6 matrix, row by row, and a vector of six.
using Block6 = std::array<double, 36>;
using Vector6 = std::array<double, 6>;

/// Cholesky factor of a symmetric positive definite matrix of 6x6 blocks in envelope storage: of each row the
/// blocks from the first that is not zero to the diagonal (Jennings 1966; George & Liu, "Computer Solution of
/// Large Sparse Positive Definite Systems", 1981, chapter 4). For matrices of some hundred rows whose pattern
/// changes each step: there is no symbolic phase, and memory is reused, which sparse libraries do not offer.
/// Rows should be ordered for a small envelope.
class EnvelopeCholesky {
 public:
  /// Makes a matrix of zeros.
  /// \param first  first column of each row whose block may differ from zero, at most the row. O(blocks).
  void reset(std::span<const Index> first);

  [[nodiscard]] Index size() const { return static_cast<Index>(first_.size()); }
  /// Block (row, column) with first[row] <= column <= row. Add to it before factor().
  [[nodiscard]] Block6& block(Index row, Index column);
  /// Replaces the matrix by its Cholesky factor. A pivot that is not positive up to rounding drops its
  /// variable: solutions have zero there, and the inverse stays positive semi-definite. O(sum of squared row
  /// lengths).
  void factor();
  /// Solves in place: b is the right side on entry and the solution on return; size() blocks. O(blocks).
  void solve(std::span<Vector6> b) const;

 private:
  [[nodiscard]] const Block6& at_place(Index row, Index column) const {
    return blocks_[begin_[static_cast<std::size_t>(row)] + static_cast<std::size_t>(column)];
  }
  void factor_diagonal(Block6& block);

  std::vector<Index> first_;
  std::vector<std::size_t> begin_;  ///< block (i, j) is at begin_[i] + j; may wrap below zero
  std::vector<Block6> blocks_;  ///< after factor(): the diagonal ones hold 1 / l_ii, or 0, on their diagonals
};

}  // namespace palpate::fem
