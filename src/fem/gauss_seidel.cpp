#include "fem/gauss_seidel.hpp"

#include <algorithm>
#include <cmath>

#include "fem/grains.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t relax_grain = 4;  // slices of a color, which are few

std::size_t slice_of(std::int32_t row) {
  return static_cast<std::size_t>(row) / simd::slice_rows;
}

}  // namespace

GaussSeidel::GaussSeidel(const BlockMatrix& matrix)
    : matrix_(&matrix),
      color_of_slice_(matrix.slice_count(), 0),
      diagonal_(simd::slice_symmetric * matrix.slice_count()),
      inverses_(diagonal_.size()),
      rest_(simd::slice_values * matrix.slice_count()) {
  const auto colors = matrix.slices_of_color();
  for (std::size_t color = 0; color < colors.size(); ++color) {
    for (const std::uint32_t slice : colors[color])
      color_of_slice_[slice] = static_cast<std::uint32_t>(color);
  }
}

/// Lists the couplings of each colour. Couplings within one colour are bounded on the diagonal.
void GaussSeidel::bound_couplings(const LinearSystem& system) {
  const auto terms = system.couplings().terms();
  const std::size_t colors = matrix_->slices_of_color().size();
  // Calls body(colour) once for each colour of a coupling.
  const auto for_each_color = [&](const simd::CouplingTerm& term, auto&& body) {
    for (std::size_t k = 0; k < 5; ++k) {
      if (term.coefficients[k] == 0.0F) continue;
      const std::uint32_t color = color_of_slice_[slice_of(term.rows[k])];
      bool first = true;
      for (std::size_t j = 0; j < k; ++j)
        first = first && (term.coefficients[j] == 0.0F || color_of_slice_[slice_of(term.rows[j])] != color);
      if (first) body(color);
    }
  };
  assign_with_room(coupling_begin_, colors + 1, 0U);
  for (const simd::CouplingTerm& term : terms)
    for_each_color(term, [&](std::uint32_t color) { ++coupling_begin_[color + 1]; });
  for (std::size_t c = 0; c < colors; ++c) coupling_begin_[c + 1] += coupling_begin_[c];
  resize_with_room(next_, colors);
  std::copy(coupling_begin_.begin(), coupling_begin_.end() - 1, next_.begin());
  resize_with_room(coupling_of_color_, coupling_begin_.back());
  for (std::size_t c = 0; c < terms.size(); ++c) {
    for_each_color(terms[c], [&](std::uint32_t color) {
      coupling_of_color_[next_[color]++] = static_cast<std::uint32_t>(c);
    });
  }
  for (const simd::CouplingTerm& term : terms) {
    for (std::size_t i = 0; i < 5; ++i) {
      for (std::size_t j = 0; j < 5; ++j) {
        const float product = std::abs(term.coefficients[i] * term.coefficients[j]);
        if (i == j || product == 0.0F) continue;
        const auto row = static_cast<std::size_t>(term.rows[i]);
        if (color_of_slice_[row / simd::slice_rows] != color_of_slice_[slice_of(term.rows[j])]) continue;
        const auto& w = term.weights;
        const std::array entries{w[0], w[5], w[10], w[1], w[2], w[6]};
        float* place =
            diagonal_.data() + simd::slice_symmetric * (row / simd::slice_rows) + row % simd::slice_rows;
        for (std::size_t k = 0; k < 6; ++k) place[simd::slice_rows * k] += product * entries[k];
      }
    }
  }
}

void GaussSeidel::update(const parallel::Threads& threads, const LinearSystem& system) {
  std::ranges::copy(system.diagonal(), diagonal_.begin());
  bound_couplings(system);
  parallel::for_chunks(threads, matrix_->slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::invert_slices(diagonal_.data(), inverses_.data(), begin, end);
                       });
}

simd::SmootherRows GaussSeidel::rows(const LinearSystem& system, const float* rotations) const {
  return {.rows = matrix_->rows(),
          .couplings = system.couplings().rows(),
          .diagonals = matrix_->diagonal_blocks().data(),
          .inverses = inverses_.data(),
          .rotations = rotations};
}

/// Calls kernel(slices, count) for the slices of a colour, with the current values of their couplings.
template <class Kernel>
void GaussSeidel::relax(const parallel::Threads& threads, LinearSystem& system, std::span<simd::Quad> z,
                        std::size_t color, Kernel&& kernel) const {
  const std::uint32_t first = coupling_begin_[color];
  system.couplings().multiply_listed(
      threads, z, std::span(coupling_of_color_).subspan(first, coupling_begin_[color + 1] - first));
  const auto& slices = matrix_->slices_of_color()[color];
  parallel::for_chunks(
      threads, slices.size(), relax_grain,
      [&](std::size_t begin, std::size_t end, std::size_t) { kernel(slices.data() + begin, end - begin); });
}

void GaussSeidel::forward(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
                          std::span<simd::Quad> z) {
  std::ranges::fill(z, simd::Quad{});
  const simd::SmootherRows all = rows(system, nullptr);
  for (std::size_t color = 0; color < matrix_->slices_of_color().size(); ++color) {
    relax(threads, system, z, color, [&](const std::uint32_t* slices, std::size_t count) {
      simd::relax_from_zero(all, r.data(), z.data(), rest_.data(), slices, count);
    });
  }
}

void GaussSeidel::backward(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
                           std::span<simd::Quad> z) const {
  const simd::SmootherRows all = rows(system, nullptr);
  for (std::size_t color = matrix_->slices_of_color().size(); color-- > 0;) {
    relax(threads, system, z, color, [&](const std::uint32_t* slices, std::size_t count) {
      simd::relax_slices(all, r.data(), z.data(), slices, count);
    });
  }
}

}  // namespace palpate::fem
