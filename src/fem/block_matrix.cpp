#include "fem/block_matrix.hpp"

#include <algorithm>
#include <cstddef>

namespace palpate::fem {
namespace {

constexpr std::size_t row_grain = 128;

}  // namespace

BlockMatrix::BlockMatrix(const Elements& elements, Index point_count) {
  gather_incidences(elements, point_count);
  build_pattern(elements);
  blocks_.resize(columns_.size());
}

void BlockMatrix::gather_incidences(const Elements& elements, Index point_count) {
  auto& begin = elements_of_point_.begin;
  begin.assign(static_cast<std::size_t>(point_count) + 1, 0);
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

void BlockMatrix::build_pattern(const Elements& elements) {
  const auto point_count = static_cast<Index>(elements_of_point_.begin.size()) - 1;
  row_begin_.push_back(0);
  diagonal_place_.assign(static_cast<std::size_t>(point_count), -1);
  places_.reserve(elements_of_point_.values.size());
  std::vector<Index> neighbors;
  for (Index row = 0; row < point_count; ++row) {
    neighbors.clear();
    for (const Index element : elements_of_point_[row]) {
      const Tet& corners = at(elements.corners(), element);
      neighbors.insert(neighbors.end(), corners.begin(), corners.end());
    }
    std::sort(neighbors.begin(), neighbors.end());
    neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
    const auto place_of = [&](Index point) {
      const auto found = std::lower_bound(neighbors.begin(), neighbors.end(), point);
      return row_begin_.back() + static_cast<Index>(found - neighbors.begin());
    };
    for (const Index element : elements_of_point_[row]) {
      const Tet& corners = at(elements.corners(), element);
      places_.push_back(
          {place_of(corners[0]), place_of(corners[1]), place_of(corners[2]), place_of(corners[3])});
    }
    if (!neighbors.empty()) at(diagonal_place_, row) = place_of(row);
    columns_.insert(columns_.end(), neighbors.begin(), neighbors.end());
    row_begin_.push_back(static_cast<Index>(columns_.size()));
  }
}

void BlockMatrix::assemble_row(const Elements& elements, Index row, double diagonal,
                               std::span<const double> factors) {
  const Index own = at(diagonal_place_, row);
  if (own < 0) return;
  for (Index place = at(row_begin_, row); place < at(row_begin_, row + 1); ++place)
    at(blocks_, place) = Matrix3{};
  const Index first = at(elements_of_point_.begin, row);
  const Index last = at(elements_of_point_.begin, row + 1);
  for (Index entry = first; entry < last; ++entry) {
    const Index element = at(elements_of_point_.values, entry);
    const auto& places = at(places_, entry);
    for (std::size_t j = 0; j < 4; ++j) {
      elements.add_stiffness(element, at(corner_of_point_, entry), static_cast<int>(j), at(factors, element),
                             at(blocks_, places[j]));
    }
  }
  Matrix3& block = at(blocks_, own);
  for (int i = 0; i < 3; ++i) block(i, i) += diagonal;
}

void BlockMatrix::assemble(const parallel::Threads& threads, const Elements& elements,
                           std::span<const double> diagonal, std::span<const double> factors) {
  parallel::for_each(threads, static_cast<std::size_t>(size()), row_grain, [&](std::size_t row) {
    assemble_row(elements, static_cast<Index>(row), diagonal[row], factors);
  });
}

std::span<const Index> BlockMatrix::columns(Index row) const {
  return std::span(columns_).subspan(static_cast<std::size_t>(at(row_begin_, row)),
                                     static_cast<std::size_t>(at(row_begin_, row + 1) - at(row_begin_, row)));
}

std::span<const Matrix3> BlockMatrix::blocks(Index row) const {
  return std::span(blocks_).subspan(static_cast<std::size_t>(at(row_begin_, row)),
                                    static_cast<std::size_t>(at(row_begin_, row + 1) - at(row_begin_, row)));
}

Matrix3 BlockMatrix::diagonal_block(Index row) const {
  const Index place = at(diagonal_place_, row);
  return place < 0 ? Matrix3{} : at(blocks_, place);
}

Vec3 BlockMatrix::row_product(Index row, std::span<const Vec3> x) const {
  Vec3 sum;
  for (Index place = at(row_begin_, row); place < at(row_begin_, row + 1); ++place) {
    sum += at(blocks_, place) * at(x, at(columns_, place));
  }
  return sum;
}

}  // namespace palpate::fem
