#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Rows of 3x3 blocks, each row in pairs of blocks: for each of three columns four values of the first block
/// and four of the second, the last of the four zero. A row with an odd number of blocks ends with one of
/// zeros.
struct BlockRows {
  const std::uint32_t* pair_begin;  ///< (n_rows + 1)
  const std::uint32_t* columns;     ///< 2 a pair
  const double* values;             ///< 24 a pair
};

/// An element at a point.
struct Incidence {
  std::uint32_t own;  ///< row of `gradients` of the point's corner: 4 element + corner
  std::array<std::uint16_t, 4>
      places;  ///< of the block with corner (corner + k) % 4, from the row's first value
};

/// Where the blocks come from: block (i, j) is the sum over the elements with corners i and j of
/// r X + X^T + tr(X) I with X = a_i a_j^T, a_i and a_j rows of `gradients`.
struct AssemblyRows {
  const std::uint32_t* pair_begin;      ///< (n_rows + 1)
  const std::int32_t* incidence_begin;  ///< (n_rows + 1)
  const Incidence* incidences;          ///< of each row, elements ascending
  const std::uint32_t* diagonal_block;  ///< (n_rows), two a pair
  const double* diagonal;               ///< (n_rows): times I, on the diagonal
  const Padded3* gradients;             ///< 4 an element
  const double* ratios;                 ///< (n_elements): r
  const std::uint8_t* mixed;            ///< (n_rows): 1 where the elements of a row may differ in r
};

/// Writes the blocks of rows [begin, end). Blocks (i, j) and (j, i) whose terms have the same order get
/// exactly transposed bits.
void assemble_rows(const AssemblyRows& rows, double* values, std::size_t begin, std::size_t end);

/// A coupling's share of a product: weights times sum_k coefficients[k] x[points[k]].
struct alignas(32) CouplingTerm {
  std::array<double, 12> weights;  ///< a symmetric matrix, column by column, each with a zero
  std::array<double, 5> coefficients;
  std::array<std::int32_t, 5> points;  ///< unused: any, with coefficient 0
};
/// What a point takes of a coupling.
struct CouplingEntry {
  std::int32_t coupling;
  double coefficient;
};
struct CouplingRows {
  const std::int32_t* begin;  ///< (n_rows + 1)
  const CouplingEntry* entries;
  const Padded3* products;  ///< a coupling each
};

/// products[c] of couplings [begin, end).
void coupling_products(const CouplingTerm* couplings, const Padded3* x, Padded3* products, std::size_t begin,
                       std::size_t end);

/// y = (blocks + couplings) x in rows [begin, end); returns the sum of x y over these rows.
double multiply_rows(const BlockRows& blocks, const CouplingRows& couplings, const Padded3* x, Padded3* y,
                     std::size_t begin, std::size_t end);

/// The vectors of conjugate gradients, a row each.
struct GradientVectors {
  Padded3* solution;
  Padded3* residual;
  Padded3* preconditioned;
  Padded3* direction;
  Padded3* product;
  const double* inverse_diagonal;  ///< 12 a row: a symmetric matrix, column by column, each with a zero
  const double* masses;            ///< a row each: m
  const double* inverse_masses;    ///< a row each
};
struct VectorSums {
  double residual = 0.0;        ///< of r r
  double by_mass = 0.0;         ///< of r r / m
  double preconditioned = 0.0;  ///< of r z
  double solution = 0.0;        ///< of m x x
};
/// x += step p, r -= step q, z = D r in rows [begin, end), with their sums.
VectorSums advance_rows(const GradientVectors& vectors, double step, std::size_t begin, std::size_t end);
/// p = z + turn p in rows [begin, end).
void turn_rows(const GradientVectors& vectors, double turn, std::size_t begin, std::size_t end);

/// The twins in plain C++.
namespace scalar {
void assemble_rows(const AssemblyRows& rows, double* values, std::size_t begin, std::size_t end);
void coupling_products(const CouplingTerm* couplings, const Padded3* x, Padded3* products, std::size_t begin,
                       std::size_t end);
double multiply_rows(const BlockRows& blocks, const CouplingRows& couplings, const Padded3* x, Padded3* y,
                     std::size_t begin, std::size_t end);
VectorSums advance_rows(const GradientVectors& vectors, double step, std::size_t begin, std::size_t end);
void turn_rows(const GradientVectors& vectors, double turn, std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
