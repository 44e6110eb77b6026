// Rows of full bodies: their blocks are sums of those of elements.
#include <algorithm>
#include <array>
#include <cstddef>

#include "fem/block_matrix.hpp"

namespace palpate::fem {
namespace {

using Block = std::array<float, 9>;

/// Adds the block of a term (16 element + 4 corner i + corner j): the one above the diagonal, or its
/// transpose, so that blocks (i, j) and (j, i) get transposed bits.
void add_term(const Elements& elements, std::uint32_t term, Block& sum) {
  const int i = static_cast<int>(term / 4 % 4);
  const int j = static_cast<int>(term % 4);
  const double* block =
      elements.full_blocks(static_cast<Index>(term / 16)) + block_place(std::min(i, j), std::max(i, j));
  if (i < j) {
    for (std::size_t k = 0; k < 9; ++k) sum[k] += static_cast<float>(block[k]);
  } else {
    for (std::size_t k = 0; k < 9; ++k) sum[k] += static_cast<float>(block[3 * (k % 3) + k / 3]);
  }
}

}  // namespace

void BlockMatrix::assemble_full(std::size_t slice) {
  const auto none = static_cast<std::uint32_t>(elements_->size());
  constexpr std::array<std::size_t, 6> upper{0, 4, 8, 1, 2, 5};
  float* diagonals = diagonal_blocks_.data() + simd::slice_symmetric * slice;
  for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
    std::array<float, 6> sums{};
    for (std::size_t slot = slot_begin_[slice]; slot < slot_begin_[slice + 1]; ++slot) {
      Block block{};
      for (std::size_t t = term_begin_[slot]; t < term_begin_[slot + 1]; ++t) {
        const std::uint32_t term = terms_[simd::slice_rows * t + lane];
        if (term / 16 != none) add_term(*elements_, term, block);
      }
      for (std::size_t k = 0; k < 9; ++k) slots_[slot].values[simd::slice_rows * k + lane] = block[k];
      for (std::size_t k = 0; k < 6; ++k) sums[k] += block[upper[k]];
    }
    const float mass = masses_[simd::slice_rows * slice + lane];
    for (std::size_t k = 0; k < 6; ++k)
      diagonals[simd::slice_rows * k + lane] = k < 3 ? mass - sums[k] : -sums[k];
  }
}

}  // namespace palpate::fem
