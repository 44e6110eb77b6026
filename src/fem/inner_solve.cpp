#include "fem/inner_solve.hpp"

#include <algorithm>
#include <cmath>

#include "fem/grains.hpp"

namespace palpate::fem {
/// x += step p, r -= step A p, and the preconditioned r. Returns the sums.
simd::VectorSums InnerSolve::advance(const parallel::Threads& threads, const simd::GradientVectors& vectors,
                                     double step) {
  parallel::for_chunks(threads, direction_.size() / simd::slice_rows, slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         partial_[chunk] =
                             simd::advance_slices(vectors, static_cast<float>(step), begin, end);
                       });
  simd::VectorSums sums;
  for (const simd::VectorSums& part : partial_) {
    sums.residual += part.residual;
    sums.preconditioned += part.preconditioned;
  }
  return sums;
}

int InnerSolve::apply(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
                      std::span<float> z, int most, double reduction) {
  const std::size_t slices = system.blocks().slice_count();
  for (auto* list : {&residual_, &preconditioned_, &product_, &zero_}) list->resize(r.size(), 0.0F);
  direction_.resize(simd::slice_rows * slices);
  partial_.resize(parallel::chunk_count(slices, slice_grain));
  parallel::for_chunks(threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    const auto own = [&](auto&& list, std::size_t width) {
      return std::span(list).subspan(width * begin, width * (end - begin));
    };
    std::ranges::copy(own(r, simd::slice_values), own(residual_, simd::slice_values).begin());
    std::ranges::fill(own(product_, simd::slice_values), 0.0F);
    std::ranges::fill(own(z, simd::slice_values), 0.0F);
    std::ranges::fill(own(direction_, simd::slice_rows), simd::Quad{});
  });
  const simd::GradientVectors vectors{.solution = z.data(),
                                      .residual = residual_.data(),
                                      .preconditioned = preconditioned_.data(),
                                      .product = product_.data(),
                                      .direction = direction_.data(),
                                      .guess = zero_.data(),
                                      .inverse_diagonal = system.inverse_diagonal().data(),
                                      .masses = system.masses().data(),
                                      .inverse_masses = system.inverse_masses().data()};
  simd::VectorSums sums = advance(threads, vectors, 0.0);
  const double enough = reduction * reduction * sums.residual;
  double beta = 0.0;
  for (int iteration = 0; iteration < most; ++iteration) {
    if (iteration > 0 && sums.residual <= enough) return iteration;
    parallel::for_chunks(threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
      simd::update_directions(vectors, static_cast<float>(beta), begin, end);
    });
    const double curvature = system.multiply(threads, direction_, product_);
    const double before = sums.preconditioned;
    const double step = before / curvature;
    if (!(curvature > 0.0) || !std::isfinite(step)) return iteration;  // rounding ends the iteration
    sums = advance(threads, vectors, step);
    beta = sums.preconditioned / before;
  }
  return most;
}

}  // namespace palpate::fem
