#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "simd/aligned.hpp"
#include "simd/envelope.hpp"

namespace palpate::fem {

/// A 6x6 matrix, row by row.
using Block6 = std::array<double, 36>;
/// A vector of six, padded with zeros.
using Vector6 = std::array<double, simd::envelope_vector>;

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
  /// Adds to block (row, column) with first[row] <= column <= row. Call before factor().
  void add(Index row, Index column, const Block6& values);
  /// Replaces the matrix by its Cholesky factor. A pivot that is not positive up to rounding drops its
  /// variable: solutions have zero there, and the inverse stays positive semi-definite. O(sum of squared row
  /// lengths).
  void factor();
  /// Solves in place: b is the right side on entry and the solution on return; size() blocks. O(blocks).
  void solve(std::span<Vector6> b);

 private:
  [[nodiscard]] simd::Envelope envelope();

  std::vector<Index> first_;
  std::vector<std::size_t> begin_;  ///< as in simd::Envelope
  simd::AlignedVector<double> blocks_;
  simd::AlignedVector<double> transposed_;
};

}  // namespace palpate::fem
