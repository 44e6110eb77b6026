#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::simd {

/// Blocks of up to three or of six rows of six doubles, each row padded to eight: Jacobians of couplings on a
/// coarse level, and blocks of the couplings' matrix.
inline constexpr std::size_t row_of_six = 8;
inline constexpr std::size_t three_rows = 3 * row_of_six;
inline constexpr std::size_t six_rows = 6 * row_of_six;

/// Two blocks and the block to which their product is added.
struct BlockTerm {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t place;
  std::uint32_t rows;  ///< of a Jacobian, 1 or 3
};

/// results[place] += first^T second for each term: two Jacobians give a block of six rows.
void add_outer_products(const double* jacobians, const BlockTerm* terms, std::size_t count, double* results);
/// results[place] += first second for each term: a Jacobian times six rows.
/// \param second  in float, six_rows numbers for each block
void add_transfers(const double* first, const float* second, const BlockTerm* terms, std::size_t count,
                   double* results);

/// The kernels above in plain C++.
namespace scalar {
void add_outer_products(const double* jacobians, const BlockTerm* terms, std::size_t count, double* results);
void add_transfers(const double* first, const float* second, const BlockTerm* terms, std::size_t count,
                   double* results);
}  // namespace scalar

}  // namespace palpate::simd
