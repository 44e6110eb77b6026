#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Rows per slice, one lane each. Arrays by row have whole slices.
inline constexpr std::size_t slice_rows = 16;
/// A vector of three for each row of a slice: all x, all y, all z.
inline constexpr std::size_t slice_values = 3 * slice_rows;
/// A symmetric matrix for each row: xx, yy, zz, xy, xz, yz.
inline constexpr std::size_t slice_symmetric = 6 * slice_rows;
/// A 3x3 block for each row of a slice: the nine entries row by row.
inline constexpr std::size_t slot_values = 9 * slice_rows;

/// Rows are grouped by colour; rows of a colour are not connected. A row stores its blocks with rows of
/// earlier colours first, then those of later colours. A slot may have earlier columns in some lanes and
/// later ones in others.
struct SliceHalves {
  std::uint32_t first_later = 0;   ///< first slot with a column of a later colour
  std::uint32_t last_earlier = 0;  ///< end of the slots with a column of an earlier colour
  std::uint32_t color_begin = 0;   ///< first row of this slice's colour: smaller columns are earlier
};

/// A matrix diag(m) + K of 3x3 blocks, where K x in row i is the sum of K_ij (x_j - x_i). So a translation
/// gives exactly no force, however the K_ij were rounded. Stored as SELL (Kreutzer et al., SIAM J. Sci.
/// Comput. 36 (2014)) with 16 rows: slot s of a slice holds one block of each row, zeros where a row has
/// fewer blocks.
struct SlicedRows {
  const std::uint32_t* slot_begin;  ///< (n_slices + 1)
  const SliceHalves* halves;        ///< (n_slices)
  const std::uint32_t* columns;     ///< 16 for each slot
  const float* values;              ///< slot_values numbers for each slot
  const float* masses;              ///< m; 16 for each slice
};

/// Input from which blocks are made: block (i, j) is the sum over the elements with corners i and j of r X +
/// X^T + tr(X) I with X = a_i a_j^T.
struct SlicedAssembly {
  const std::uint32_t* slot_begin;  ///< (n_slices + 1)
  const std::uint32_t* term_begin;  ///< (n_slots + 1): first term of each slot, 16 a term
  const std::uint32_t* terms;  ///< 16 element + 4 corner i + corner j; padding refers to an element of zeros
  const Quad* gradients;       ///< 4 for each element: a_i, with r as fourth value
  const float* masses;         ///< 16 for each slice
  bool mixed;                  ///< r may differ between the elements of a row
};

/// Writes the blocks of slices [begin, end), and the diagonal blocks: the masses minus all other blocks of
/// the row, since K gives no force for a translation. Blocks (i, j) and (j, i) whose terms have the same
/// order get exactly transposed bits.
void assemble_slices(const SlicedAssembly& rows, float* values, float* diagonals, std::size_t begin,
                     std::size_t end);

/// Input of rows whose blocks are sums of stored blocks of nine numbers, row by row.
struct TangentAssembly {
  const std::uint32_t* slot_begin;  ///< (n_slices + 1)
  const std::uint32_t* term_begin;  ///< (n_slots + 1): first term of each slot, 16 a term
  const std::uint32_t* terms;       ///< 2 place of the first number + 1 if the block is to be transposed
  const float* blocks;
};

/// Writes the blocks of slices [begin, end). Blocks (i, j) and (j, i) get transposed bits as above.
void assemble_tangent_slices(const TangentAssembly& rows, float* values, std::size_t begin, std::size_t end);
/// The diagonal blocks of slices [begin, end), from their blocks: as assemble_slices() writes them.
/// \param slot_begin, masses  as in SlicedRows
void sum_diagonals(const std::uint32_t* slot_begin, const float* values, const float* masses,
                   float* diagonals, std::size_t begin, std::size_t end);

/// The part of a product in one coupling: weights times sum_k coefficients[k] x[rows[k]].
struct alignas(16) CouplingTerm {
  std::array<float, 12> weights;  ///< a symmetric matrix, column by column, each padded with a zero
  std::array<float, 5> coefficients;
  std::array<std::int32_t, 5> rows;  ///< unused entries: any row, with coefficient 0
};
/// The part of a coupling's product at one point.
struct CouplingEntry {
  std::int32_t coupling;
  float coefficient;
};
struct CouplingRows {
  const std::int32_t* begin;  ///< (n_rows + 1)
  const CouplingEntry* entries;
  const Quad* products;  ///< one per coupling
};

/// products[c] of couplings [begin, end).
void coupling_products(const CouplingTerm* couplings, const Quad* x, Quad* products, std::size_t begin,
                       std::size_t end);

/// y = (rows + couplings) x in slices [begin, end); returns the sum of x y over them.
double multiply_slices(const SlicedRows& rows, const CouplingRows& couplings, const Quad* x, float* y,
                       std::size_t begin, std::size_t end);

/// Inverses of symmetric positive definite blocks A of slices [begin, end), as A^-1 = G^T G with G = L^-1.
/// Rounding keeps this form positive definite, however stiff a contact is in one direction. Where rounding
/// leaves no L, the inverse of the diagonal. Rows of zeros stay zero.
void invert_slices(const float* blocks, float* inverses, std::size_t begin, std::size_t end);

/// The vectors of conjugate gradients. Each has slice_values numbers for a slice, except the direction.
struct GradientVectors {
  float* solution;
  float* residual;
  float* preconditioned;
  float* product;
  Quad* direction;                ///< (n_rows)
  const float* guess;             ///< first guess, to which the solution is added
  const float* inverse_diagonal;  ///< slice_symmetric numbers for each slice
  const float* masses;            ///< m; 16 for each slice
  const float* inverse_masses;    ///< 1 / m; 16 for each slice, 0 in padding rows
};
struct VectorSums {
  double residual = 0.0;        ///< sum of r r
  double by_mass = 0.0;         ///< sum of r r / m
  double preconditioned = 0.0;  ///< sum of r z
  double solution = 0.0;        ///< sum of m (guess + x)^2
};
/// x += step p, r -= step q, z = D r in slices [begin, end). Returns their sums.
VectorSums advance_slices(const GradientVectors& vectors, float step, std::size_t begin, std::size_t end);
/// p = z + beta p in slices [begin, end).
void update_directions(const GradientVectors& vectors, float beta, std::size_t begin, std::size_t end);

/// The kernels above in plain C++.
namespace scalar {
void assemble_slices(const SlicedAssembly& rows, float* values, float* diagonals, std::size_t begin,
                     std::size_t end);
void assemble_tangent_slices(const TangentAssembly& rows, float* values, std::size_t begin, std::size_t end);
void sum_diagonals(const std::uint32_t* slot_begin, const float* values, const float* masses,
                   float* diagonals, std::size_t begin, std::size_t end);
void coupling_products(const CouplingTerm* couplings, const Quad* x, Quad* products, std::size_t begin,
                       std::size_t end);
double multiply_slices(const SlicedRows& rows, const CouplingRows& couplings, const Quad* x, float* y,
                       std::size_t begin, std::size_t end);
void invert_slices(const float* blocks, float* inverses, std::size_t begin, std::size_t end);
VectorSums advance_slices(const GradientVectors& vectors, float step, std::size_t begin, std::size_t end);
void update_directions(const GradientVectors& vectors, float beta, std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
