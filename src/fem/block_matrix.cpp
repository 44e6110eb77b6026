#include "fem/block_matrix.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include <palpate/error.hpp>

namespace palpate::fem {
namespace {

constexpr std::size_t row_grain = 128;
constexpr Index most_elements = Index{1} << 29;  // element and corner in 31 bits
constexpr std::size_t most_blocks = 5460;        // of a row: places in 16 bits

}  // namespace

BlockMatrix::BlockMatrix(const Elements& elements, std::span<const std::uint8_t> free)
    : block_count_(free.size(), 0),
      diagonal_block_(free.size(), 0),
      mixed_(free.size(), 0),
      diagonal_(free.size(), 1.0) {
  if (elements.size() >= most_elements) {
    throw Error("dynamics", "elements", std::to_string(elements.size()),
                "fewer than " + std::to_string(most_elements));
  }
  gather_incidences(elements);
  pair_begin_.push_back(0);
  for (Index row = 0; row < size(); ++row) {
    if (at(free, row) != 0) build_row(elements, row);
    pair_begin_.push_back(static_cast<std::uint32_t>(columns_.size() / 2));
  }
  find_mixed_rows(elements);
  pairs_.resize(columns_.size() / 2);
}

void BlockMatrix::gather_incidences(const Elements& elements) {
  auto& begin = elements_of_point_.begin;
  begin.assign(diagonal_.size() + 1, 0);
  for (const Tet& corners : elements.corners()) {
    for (const Index point : corners) ++at(begin, point + 1);
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  elements_of_point_.values.resize(static_cast<std::size_t>(begin.back()));
  incidences_.resize(elements_of_point_.values.size());
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index element = 0; element < elements.size(); ++element) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Index entry = at(next, at(elements.corners(), element)[corner])++;
      at(elements_of_point_.values, entry) = element;
      at(incidences_, entry).own =
          4 * static_cast<std::uint32_t>(element) + static_cast<std::uint32_t>(corner);
    }
  }
}

void BlockMatrix::build_row(const Elements& elements, Index row) {
  const std::size_t first = columns_.size();
  for (const Index element : elements_of_point_[row]) {
    for (const Index point : at(elements.corners(), element))
      columns_.push_back(static_cast<std::uint32_t>(point));
  }
  const auto own = columns_.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(own, columns_.end());
  columns_.erase(std::unique(own, columns_.end()), columns_.end());
  const std::size_t count = columns_.size() - first;
  if (count > most_blocks) {
    throw Error("dynamics", "point " + std::to_string(row), std::to_string(count) + " neighbours",
                "at most " + std::to_string(most_blocks));
  }
  at(block_count_, row) = static_cast<std::uint32_t>(count);
  const auto place_of = [&](Index point) {
    const auto found = std::lower_bound(own, columns_.end(), static_cast<std::uint32_t>(point));
    return static_cast<std::size_t>(found - own);
  };
  const Index last = at(elements_of_point_.begin, row + 1);
  for (Index entry = at(elements_of_point_.begin, row); entry < last; ++entry) {
    const Tet& corners = at(elements.corners(), at(elements_of_point_.values, entry));
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t place = place_of(corners[(at(incidences_, entry).own + k) % 4]);
      at(incidences_, entry).places[k] = static_cast<std::uint16_t>(24 * (place / 2) + 4 * (place % 2));
    }
  }
  if (count > 0) at(diagonal_block_, row) = static_cast<std::uint32_t>(first + place_of(row));
  if (count % 2 != 0) columns_.push_back(static_cast<std::uint32_t>(row));
}

/// The blocks (i, j) and (j, i) must be made alike: bodies as a whole, whose blocks are all their own.
void BlockMatrix::find_mixed_rows(const Elements& elements) {
  const auto bodies = elements.body_of_element();
  std::vector<std::uint8_t> mixed(bodies.empty() ? 0 : static_cast<std::size_t>(bodies.back()) + 1, 0);
  for (std::size_t e = 1; e < bodies.size(); ++e) {
    const bool same = bodies[e] != bodies[e - 1] || elements.ratios()[e] == elements.ratios()[e - 1];
    if (!same) at(mixed, bodies[e]) = 1;
  }
  for (std::size_t e = 0; e < bodies.size(); ++e) {
    for (const Index point : elements.corners()[e]) at(mixed_, point) = at(mixed, bodies[e]);
  }
}

void BlockMatrix::assemble(const parallel::Threads& threads, const Elements& elements,
                           std::span<const double> diagonal) {
  std::copy(diagonal.begin(), diagonal.end(), diagonal_.begin());
  if (pairs_.empty()) return;
  const simd::AssemblyRows rows{.pair_begin = pair_begin_.data(),
                                .incidence_begin = elements_of_point_.begin.data(),
                                .incidences = incidences_.data(),
                                .diagonal_block = diagonal_block_.data(),
                                .diagonal = diagonal_.data(),
                                .gradients = elements.gradients().data(),
                                .ratios = elements.ratios().data(),
                                .mixed = mixed_.data()};
  parallel::for_chunks(threads, diagonal_.size(), row_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::assemble_rows(rows, pairs_.front().values.data(), begin, end);
                       });
}

std::span<const std::uint32_t> BlockMatrix::columns(Index row) const {
  return std::span(columns_).subspan(std::size_t{2} * at(pair_begin_, row), at(block_count_, row));
}

Matrix3 BlockMatrix::block(Index row, std::size_t place) const {
  const auto& pair = pairs_[at(pair_begin_, row) + place / 2].values;
  Matrix3 block;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      block(i, j) = pair[8 * static_cast<std::size_t>(j) + 4 * (place % 2) + static_cast<std::size_t>(i)];
    }
  }
  return block;
}

SymmetricMatrix3 BlockMatrix::diagonal_block(Index row) const {
  if (at(block_count_, row) == 0) return {};
  const std::uint32_t place = at(diagonal_block_, row);
  const double* b = pairs_[place / 2].values.data() + std::size_t{4} * (place % 2);
  return {b[0], b[9], b[18], b[8], b[16], b[17]};
}

simd::BlockRows BlockMatrix::rows() const {
  return {.pair_begin = pair_begin_.data(),
          .columns = columns_.data(),
          .values = pairs_.empty() ? nullptr : pairs_.front().values.data()};
}

}  // namespace palpate::fem
