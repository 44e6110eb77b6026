#include "fem/block_matrix.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include <palpate/error.hpp>

namespace palpate::fem {
namespace {

constexpr std::size_t row_grain = 128;
constexpr Index most_elements = Index{1} << 28;  // a term keeps element and two corners in 32 bits

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
  term_begin_.push_back(0);
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
  corner_of_point_.resize(elements_of_point_.values.size());
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index element = 0; element < elements.size(); ++element) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Index entry = at(next, at(elements.corners(), element)[corner])++;
      at(elements_of_point_.values, entry) = element;
      at(corner_of_point_, entry) = static_cast<std::uint8_t>(corner);
    }
  }
}

void BlockMatrix::build_row(const Elements& elements, Index row) {
  struct Term {
    std::uint32_t column;
    std::uint32_t term;
    auto operator<=>(const Term&) const = default;
  };
  std::vector<Term> terms;
  const Index last = at(elements_of_point_.begin, row + 1);
  for (Index entry = at(elements_of_point_.begin, row); entry < last; ++entry) {
    const auto element = static_cast<std::uint32_t>(at(elements_of_point_.values, entry));
    const std::uint32_t own = 4 * element + at(corner_of_point_, entry);
    for (std::uint32_t other = 0; other < 4; ++other) {
      terms.push_back({static_cast<std::uint32_t>(at(elements.corners(), element)[other]), 4 * own + other});
    }
  }
  std::sort(terms.begin(), terms.end());  // by column, then by element
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (t == 0 || terms[t].column != terms[t - 1].column) {
      if (t > 0) term_begin_.push_back(static_cast<std::uint32_t>(terms_.size()));
      if (terms[t].column == static_cast<std::uint32_t>(row))
        at(diagonal_block_, row) = static_cast<std::uint32_t>(columns_.size());
      columns_.push_back(terms[t].column);
      ++at(block_count_, row);
    }
    terms_.push_back(terms[t].term);
  }
  if (!terms.empty()) term_begin_.push_back(static_cast<std::uint32_t>(terms_.size()));
  if (columns_.size() % 2 != 0) {
    columns_.push_back(static_cast<std::uint32_t>(row));
    term_begin_.push_back(static_cast<std::uint32_t>(terms_.size()));
  }
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
  const simd::BlockTerms terms{.pair_begin = pair_begin_.data(),
                               .term_begin = term_begin_.data(),
                               .terms = terms_.data(),
                               .diagonal_block = diagonal_block_.data(),
                               .diagonal = diagonal_.data(),
                               .gradients = elements.gradients().data(),
                               .ratios = elements.ratios().data(),
                               .mixed = mixed_.data()};
  parallel::for_chunks(threads, diagonal_.size(), row_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::assemble_rows(terms, pairs_.front().values.data(), begin, end);
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
  const Matrix3 b = block(row, at(diagonal_block_, row) - std::size_t{2} * at(pair_begin_, row));
  return {b(0, 0), b(1, 1), b(2, 2), b(0, 1), b(0, 2), b(1, 2)};
}

simd::BlockRows BlockMatrix::rows() const {
  return {.pair_begin = pair_begin_.data(),
          .columns = columns_.data(),
          .values = pairs_.empty() ? nullptr : pairs_.front().values.data()};
}

}  // namespace palpate::fem
