// Rows of bodies with tangent blocks: each block of a row is a sum of blocks of elements.
#include <algorithm>
#include <array>
#include <cstddef>

#include "fem/block_matrix.hpp"

namespace palpate::fem {
namespace {

using Block = std::array<float, 9>;

/// Adds the block of a term (16 element + 4 corner i + corner j): the stored one above the diagonal or its
/// transpose, so that blocks (i, j) and (j, i) get transposed bits.
void add_term(const Elements& elements, std::uint32_t term, Block& sum) {
  const int i = static_cast<int>(term / 4 % 4);
  const int j = static_cast<int>(term % 4);
  const float* block =
      elements.element_tangent(static_cast<Index>(term / 16)) + block_place(std::min(i, j), std::max(i, j));
  if (i < j) {
    for (std::size_t k = 0; k < 9; ++k) sum[k] += block[k];
  } else {
    for (std::size_t k = 0; k < 9; ++k) sum[k] += block[3 * (k % 3) + k / 3];
  }
}

}  // namespace

void BlockMatrix::place_domains() {
  const SmoothingDomains& domains = elements_->smoothing();
  if (domains.empty()) return;
  domain_slot_begin_.push_back(0);
  for (Index point = 0; point < size(); ++point) {
    const Index row = at(row_of_point_, point);
    const auto own = columns(point);
    for (const SmoothingDomains::Entry& entry : domains.entries(point)) {
      for (const Index other : domains.points(entry.domain)) {
        if (row < 0 || other == point) continue;
        const auto place = std::ranges::lower_bound(own, static_cast<std::uint32_t>(other)) - own.begin();
        const std::uint32_t slot =
            slot_of_column_[at(column_begin_, point) + static_cast<std::size_t>(place)];
        const std::uint32_t first = slot_begin_[static_cast<std::size_t>(row) / simd::slice_rows];
        domain_slots_.push_back(static_cast<std::uint16_t>(slot - first));
      }
      domain_slot_begin_.push_back(domain_slots_.size());
    }
  }
}

/// Adds the blocks of smoothing domains at the point of a row, domains ascending, so that (i, j) and (j, i)
/// have the same sums.
void BlockMatrix::add_domains(std::size_t row) {
  const SmoothingDomains& domains = elements_->smoothing();
  const Index point = row < point_of_row_.size() ? point_of_row_[row] : -1;
  if (point < 0 || domains.empty()) return;
  const std::size_t first = slot_begin_[row / simd::slice_rows];
  const std::size_t lane = row % simd::slice_rows;
  std::size_t number = domains.first_entry(point);
  for (const SmoothingDomains::Entry& entry : domains.entries(point)) {
    const std::uint16_t* slot = domain_slots_.data() + domain_slot_begin_[number++];
    domains.for_each_block(entry, [&](const Block& block) {
      float* values = slots_[first + *slot++].values.data() + lane;
      for (std::size_t k = 0; k < 9; ++k) values[simd::slice_rows * k] += block[k];
    });
  }
}

void BlockMatrix::assemble_tangent(std::size_t slice) {
  const auto none = static_cast<std::uint32_t>(elements_->size());
  constexpr std::array<std::size_t, 6> upper{0, 4, 8, 1, 2, 5};
  float* diagonals = diagonal_blocks_.data() + simd::slice_symmetric * slice;
  for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
    for (std::size_t slot = slot_begin_[slice]; slot < slot_begin_[slice + 1]; ++slot) {
      Block block{};
      for (std::size_t t = term_begin_[slot]; t < term_begin_[slot + 1]; ++t) {
        const std::uint32_t term = terms_[simd::slice_rows * t + lane];
        if (term / 16 != none) add_term(*elements_, term, block);
      }
      for (std::size_t k = 0; k < 9; ++k) slots_[slot].values[simd::slice_rows * k + lane] = block[k];
    }
    add_domains(simd::slice_rows * slice + lane);
    std::array<float, 6> sums{};
    for (std::size_t slot = slot_begin_[slice]; slot < slot_begin_[slice + 1]; ++slot) {
      for (std::size_t k = 0; k < 6; ++k) sums[k] += slots_[slot].values[simd::slice_rows * upper[k] + lane];
    }
    const float mass = masses_[simd::slice_rows * slice + lane];
    for (std::size_t k = 0; k < 6; ++k)
      diagonals[simd::slice_rows * k + lane] = k < 3 ? mass - sums[k] : -sums[k];
  }
}

}  // namespace palpate::fem
