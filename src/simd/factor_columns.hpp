#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/sliced_rows.hpp"

namespace palpate::simd {

/// A Cholesky factor L of 3x3 blocks, column by column; a block is stored column by column, nine values, and
/// after the last there are three more.
struct FactorColumns {
  const std::uint32_t* begin;  ///< (n_columns + 1): blocks below the diagonal
  const std::uint32_t* rows;   ///< of each block
  const float* blocks;         ///< 9 a block
  const float* inverses;       ///< 9 a column: inverse of the block on the diagonal
};

struct ColumnRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

/// b becomes (L L^T)^-1 b in two ranges of columns, each of which no block joins to others: side by side,
/// since in each a column waits for the last. The bits are those of one range at a time. What w holds is
/// lost.
void solve_columns(const FactorColumns& columns, Quad* b, ColumnRange first, ColumnRange second);

/// The rows of a matrix and what turns them: rotations of rows, and where their vectors are in the order of
/// the factor.
struct TurnedRows {
  const std::uint32_t* slot_begin;  ///< (n_slices + 1)
  const std::uint32_t* columns;     ///< 16 a slot
  const float* edges;               ///< slice_values a slot: e_ij, so that F = sum (x_j - x_i) e_ij^T
  const std::uint32_t* places;      ///< 16 a slice: of the row in the order of the factor
  const float* taken;               ///< 16 a slice: 1 where the factor has the row, 0 where not
  float* rotations;                 ///< slot_values a slice
};

/// Rotations nearest to the F of the rows of slices [begin, end) at these positions (n_rows): those of three
/// Higham iterations, which are not exact where a row is strained by more than a tenth or so; none where F is
/// flat or inverted.
void find_rotations(const TurnedRows& rows, const Quad* positions, std::size_t begin, std::size_t end);
/// quads[place] = R^T r of slices [begin, end), zero where a row is not taken.
void turn_back(const TurnedRows& rows, const float* r, Quad* quads, std::size_t begin, std::size_t end);
/// z = R quads[place] where a row is taken; returns the sum of r z over all rows of slices [begin, end).
double turn_forth(const TurnedRows& rows, const float* r, const Quad* quads, float* z, std::size_t begin,
                  std::size_t end);

/// The twins in plain C++.
namespace scalar {
void solve_columns(const FactorColumns& columns, Quad* b, ColumnRange first, ColumnRange second);
void find_rotations(const TurnedRows& rows, const Quad* positions, std::size_t begin, std::size_t end);
void turn_back(const TurnedRows& rows, const float* r, Quad* quads, std::size_t begin, std::size_t end);
double turn_forth(const TurnedRows& rows, const float* r, const Quad* quads, float* z, std::size_t begin,
                  std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
