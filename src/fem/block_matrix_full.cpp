// Rows of bodies with tangent blocks: each block of a row is a sum of blocks of elements.
#include <algorithm>
#include <cstddef>

#include "fem/block_matrix.hpp"
#include "simd/hyperelastic_pass.hpp"

namespace palpate::fem {

/// The term of block (i, j) of an element, for TangentAssembly: the stored one above the diagonal or its
/// transpose, so that blocks (i, j) and (j, i) get transposed bits.
std::uint32_t BlockMatrix::tangent_term(Index element, int i, int j) const {
  const std::size_t place = elements_->tangent_place(element, std::min(i, j), std::max(i, j));
  return 2 * static_cast<std::uint32_t>(place) + (i < j ? 0U : 1U);
}

std::uint32_t BlockMatrix::empty_tangent_term() const {
  return 2 * static_cast<std::uint32_t>(elements_->tangents().size() - simd::block_stride);
}

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
    domains.for_each_block(entry, [&](const SmoothingDomains::Block& block) {
      float* values = slots_[first + *slot++].values.data() + lane;
      for (std::size_t k = 0; k < 9; ++k) values[simd::slice_rows * k] += block[k];
    });
  }
}

void BlockMatrix::assemble_tangent(std::size_t begin, std::size_t end) {
  if (begin == end) return;
  const simd::TangentAssembly rows{.slot_begin = slot_begin_.data(),
                                   .term_begin = term_begin_.data(),
                                   .terms = terms_.data(),
                                   .blocks = elements_->tangents().data()};
  float* values = slots_.empty() ? nullptr : slots_.front().values.data();
  simd::assemble_tangent_slices(rows, values, begin, end);
  for (std::size_t row = simd::slice_rows * begin; row < simd::slice_rows * end; ++row) add_domains(row);
  simd::sum_diagonals(slot_begin_.data(), values, masses_.data(), diagonal_blocks_.data(), begin, end);
}

}  // namespace palpate::fem
