#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// A vector of six, padded with two zeros.
struct alignas(32) Six {
  std::array<float, 8> values{};
};

/// Rows of blocks of six by six, three by six or six by three. Blocks are stored column by column: columns of
/// six values padded to eight, those of three to four. Column indices of a row ascend.
struct PaddedRows {
  const std::uint32_t* begin;    ///< (n_rows + 1)
  const std::uint32_t* columns;  ///< column of each block
  const float* blocks;
};
inline constexpr std::size_t six_by_six = 48;
inline constexpr std::size_t six_by_three = 24;
inline constexpr std::size_t three_by_six = 24;

/// y = A x in rows [begin, end), with blocks of six rows and three columns.
void multiply_six_by_three(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end);
/// y = A x in rows [begin, end), with blocks of three rows and six columns.
void multiply_three_by_six(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end);
/// y = A x, or y += A x, with blocks of six by six.
void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end);
void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end);

/// A symmetric matrix of six by six blocks: the off-diagonal part as the sum of two, and the inverses of the
/// diagonal blocks.
struct SixMatrix {
  PaddedRows first;
  PaddedRows second;
  const float* inverses;  ///< six_by_six numbers for each row
};
/// Block Gauss-Seidel for A x = b, row by row: a forward sweep from x = 0, then a backward sweep from x.
/// Ignores columns outside [begin, end).
void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
/// A forward sweep that starts from x.
void relax_forward_from(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
/// r = b - A x in rows [begin, end), after relax_forward() of all rows. After relax_forward_from() of all
/// rows, pass the change of x as x.
void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end);

/// The kernels above in plain C++.
namespace scalar {
void multiply_six_by_three(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end);
void multiply_three_by_six(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end);
void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end);
void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end);
void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
void relax_forward_from(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end);
void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
