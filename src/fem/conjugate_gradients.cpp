#include "fem/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

constexpr std::size_t row_grain = 256;

double dot(const simd::Padded3& a, const simd::Padded3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace

/// residual = b - A x for the better of the guess and zero; returns |b|. Where that is 0, x = 0.
double ConjugateGradients::start(const parallel::Threads& threads, LinearSystem& system,
                                 std::span<const simd::Padded3> b, std::span<simd::Padded3> x) {
  const double squared_b =
      parallel::sum(threads, b.size(), partial_sums_, [&](std::size_t i) { return dot(b[i], b[i]); });
  if (squared_b == 0.0) {
    std::fill(x.begin(), x.end(), simd::Padded3{});
    return 0.0;
  }
  system.multiply(threads, x, product_);
  // Squared residual of the guess below that of zero by this much.
  const double gain = parallel::sum(threads, b.size(), partial_sums_, [&](std::size_t i) {
    residual_[i] = {b[i].x - product_[i].x, b[i].y - product_[i].y, b[i].z - product_[i].z, 0.0};
    return dot(b[i], b[i]) - dot(residual_[i], residual_[i]);
  });
  if (!(gain >= 0.0)) {
    std::fill(x.begin(), x.end(), simd::Padded3{});
    std::copy(b.begin(), b.end(), residual_.begin());
  }
  std::fill(direction_.begin(), direction_.end(), simd::Padded3{});
  std::fill(product_.begin(), product_.end(), simd::Padded3{});
  return std::sqrt(squared_b);
}

simd::VectorSums ConjugateGradients::advance(const parallel::Threads& threads,
                                             const simd::GradientVectors& vectors, double step) {
  parallel::for_chunks(threads, residual_.size(), row_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         partial_[chunk] = simd::advance_rows(vectors, step, begin, end);
                       });
  simd::VectorSums sums;
  for (const simd::VectorSums& part : partial_) {
    sums.residual += part.residual;
    sums.by_mass += part.by_mass;
    sums.preconditioned += part.preconditioned;
    sums.solution += part.solution;
  }
  return sums;
}

void ConjugateGradients::turn(const parallel::Threads& threads, const simd::GradientVectors& vectors,
                              double turn) {
  parallel::for_chunks(
      threads, residual_.size(), row_grain,
      [&](std::size_t begin, std::size_t end, std::size_t) { simd::turn_rows(vectors, turn, begin, end); });
}

SolveReport ConjugateGradients::solve(const parallel::Threads& threads, LinearSystem& system,
                                      std::span<const simd::Padded3> b, std::span<simd::Padded3> x,
                                      const SolveGoal& goal, CoarseSpace* coarse,
                                      std::span<const Vec3> positions) {
  for (auto* vector : {&residual_, &preconditioned_, &direction_, &product_}) vector->resize(system.size());
  partial_.resize(parallel::chunk_count(system.size(), row_grain));
  const double size_b = start(threads, system, b, x);
  if (size_b == 0.0) return {.converged = true};
  const simd::GradientVectors vectors{.solution = x.data(),
                                      .residual = residual_.data(),
                                      .preconditioned = preconditioned_.data(),
                                      .direction = direction_.data(),
                                      .product = product_.data(),
                                      .inverse_diagonal = &system.inverse_diagonal().data()->x,
                                      .masses = system.masses().data(),
                                      .inverse_masses = system.inverse_masses().data()};
  simd::VectorSums sums = advance(threads, vectors, 0.0);
  estimate_.clear();
  SolveReport report;
  const int jacobi_iterations = goal.preconditioner == Preconditioner::two_level ? 0
                                : coarse != nullptr && goal.preconditioner == Preconditioner::automatic
                                    ? patience(*coarse)
                                    : std::numeric_limits<int>::max();
  const bool fixed = goal.fixed_iterations > 0;
  const int most = fixed ? goal.fixed_iterations : goal.max_iterations;
  double turned = 0.0;
  while (true) {
    const double residual = std::sqrt(sums.residual);
    const double error = std::min(std::sqrt(sums.by_mass), estimate_.error());
    report.relative_residual = residual / std::max(size_b, goal.least_residual);
    report.relative_error = error / std::max(std::sqrt(sums.solution), goal.least_scale);
    report.converged =
        (goal.of_solution ? report.relative_error : report.relative_residual) <= goal.tolerance;
    if ((report.converged && !fixed) || report.iterations >= most || sums.residual == 0.0) break;
    if (coarse != nullptr && report.iterations == jacobi_iterations) {
      system.update_coarse(threads, *coarse, positions);
      sums.preconditioned += coarse->correct(threads, residual_, preconditioned_);
      report.two_level = true;
      turned = 0.0;  // the directions so far are conjugate in vain
      estimate_.clear();
    }
    turn(threads, vectors, turned);
    const double curvature = system.multiply(threads, direction_, product_);
    const double step = sums.preconditioned / curvature;
    if (!(curvature > 0.0) || !std::isfinite(step)) break;
    const double before = sums.preconditioned;
    estimate_.add(step * before);
    sums = advance(threads, vectors, step);
    if (report.two_level) sums.preconditioned += coarse->correct(threads, residual_, preconditioned_);
    turned = sums.preconditioned / before;
    ++report.iterations;
  }
  return report;
}

}  // namespace palpate::fem
