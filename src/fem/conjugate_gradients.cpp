#include "fem/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t point_grain = 1024;

}  // namespace

double ConjugateGradients::inner_product(const parallel::Threads& threads, std::span<const Vec3> a,
                                         std::span<const Vec3> b) {
  return parallel::sum(threads, a.size(), partial_, [&](std::size_t i) { return dot(a[i], b[i]); });
}

/// residual = b - A x for the better of the guess and zero; returns its norm.
double ConjugateGradients::start(const parallel::Threads& threads, LinearSystem& system,
                                 std::span<const Vec3> b, double norm_b, std::span<Vec3> x) {
  system.multiply(threads, x, product_);
  parallel::for_each(threads, b.size(), point_grain,
                     [&](std::size_t i) { residual_[i] = b[i] - product_[i]; });
  const double norm = std::sqrt(inner_product(threads, residual_, residual_));
  if (norm <= norm_b) return norm;
  std::fill(x.begin(), x.end(), Vec3{});
  std::copy(b.begin(), b.end(), residual_.begin());
  return norm_b;
}

/// preconditioned = P^-1 residual; returns their inner product.
double ConjugateGradients::precondition(const parallel::Threads& threads, const LinearSystem& system) {
  parallel::for_each(threads, residual_.size(), point_grain,
                     [&](std::size_t i) { preconditioned_[i] = system.precondition(i, residual_[i]); });
  return inner_product(threads, residual_, preconditioned_);
}

SolveReport ConjugateGradients::solve(const parallel::Threads& threads, LinearSystem& system,
                                      std::span<const Vec3> b, std::span<Vec3> x, double tolerance,
                                      int max_iterations, double least_scale) {
  for (auto* vector : {&residual_, &preconditioned_, &direction_, &product_}) vector->resize(system.size());
  const double norm_b = std::sqrt(inner_product(threads, b, b));
  if (norm_b == 0.0) {
    std::fill(x.begin(), x.end(), Vec3{});
    return {0, 0.0, true};
  }
  const double scale = std::max(norm_b, least_scale);
  double norm = start(threads, system, b, norm_b, x);
  double rz = precondition(threads, system);
  std::copy(preconditioned_.begin(), preconditioned_.end(), direction_.begin());
  SolveReport report;
  while (norm > tolerance * scale && report.iterations < max_iterations) {
    system.multiply(threads, direction_, product_);
    const double curvature = inner_product(threads, direction_, product_);
    const double step = rz / curvature;
    if (!(curvature > 0.0) || !std::isfinite(step)) break;
    parallel::for_each(threads, x.size(), point_grain, [&](std::size_t i) {
      x[i] += step * direction_[i];
      residual_[i] -= step * product_[i];
    });
    ++report.iterations;
    norm = std::sqrt(inner_product(threads, residual_, residual_));
    const double rz_previous = rz;
    rz = precondition(threads, system);
    const double turn = rz / rz_previous;
    parallel::for_each(threads, x.size(), point_grain,
                       [&](std::size_t i) { direction_[i] = preconditioned_[i] + turn * direction_[i]; });
  }
  report.relative_residual = norm / scale;
  report.converged = norm <= tolerance * scale;
  return report;
}

}  // namespace palpate::fem
