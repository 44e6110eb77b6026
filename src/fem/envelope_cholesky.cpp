#include "fem/envelope_cholesky.hpp"

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate::fem {

void EnvelopeCholesky::reset(std::span<const Index> first) {
  first_.assign(first.begin(), first.end());
  resize_with_room(begin_, first.size());
  std::size_t count = 0;
  for (std::size_t row = 0; row < first.size(); ++row) {
    begin_[row] = count - static_cast<std::size_t>(first[row]);
    count += row + 1 - static_cast<std::size_t>(first[row]);
  }
  assign_with_room(blocks_, simd::envelope_block * count, 0.0);
  assign_with_room(transposed_, simd::envelope_block * count, 0.0);
}

void EnvelopeCholesky::add(Index row, Index column, const Block6& values) {
  double* block =
      blocks_.data() + simd::envelope_block * (at(begin_, row) + static_cast<std::size_t>(column));
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) block[simd::envelope_vector * j + i] += values[6 * i + j];
  }
}

simd::Envelope EnvelopeCholesky::envelope() {
  return {.rows = first_.size(),
          .first = first_.data(),
          .begin = begin_.data(),
          .blocks = blocks_.data(),
          .transposed = transposed_.data()};
}

void EnvelopeCholesky::factor() {
  simd::factor_envelope(envelope());
}

void EnvelopeCholesky::solve(std::span<Vector6> b) {
  if (b.empty()) return;
  simd::solve_envelope(envelope(), b.data()->data());
}

}  // namespace palpate::fem
