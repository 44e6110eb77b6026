#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::simd {

/// A block of six columns of six doubles, each padded to eight with zeros.
inline constexpr std::size_t envelope_block = 48;
inline constexpr std::size_t envelope_vector = 8;

/// A lower triangular matrix of 6x6 blocks in envelope storage. Block (i, j) with first[i] <= j <= i begins
/// at envelope_block (begin[i] + j).
struct Envelope {
  std::size_t rows;
  const std::int32_t* first;
  const std::size_t* begin;  ///< may wrap below zero
  double* blocks;
  double* transposed;  ///< the blocks below the diagonal of the factor, transposed
};

/// Replaces the lower half of a symmetric matrix by its Cholesky factor, and writes the transposed blocks.
/// Blocks on the diagonal hold 1 / l_ii on their diagonals. A pivot that is not positive up to rounding is 0,
/// with its column.
void factor_envelope(const Envelope& a);
/// Solves in place with the factor: x is the right side on entry; envelope_vector numbers for each row.
void solve_envelope(const Envelope& a, double* x);

/// The kernels above in plain C++.
namespace scalar {
void factor_envelope(const Envelope& a);
void solve_envelope(const Envelope& a, double* x);
}  // namespace scalar

}  // namespace palpate::simd
