// The vectors of conjugate gradients: in double by point, in float by row.
#include <algorithm>
#include <cmath>

#include "fem/conjugate_gradients.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"

namespace palpate::fem {
namespace {

simd::Padded3 minus(const simd::Padded3& a, const simd::Padded3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z, 0.0};
}

}  // namespace

/// Sets the rigid part of the true residual.
void ConjugateGradients::find_rigid_change(Run& run) {
  if (run.goal.fixed_iterations > 0 || run.positions.empty()) return;
  run.rigid_change = run.system.rigid_change(run.threads, residual_, run.positions);
}

void ConjugateGradients::find_residual(Run& run) {
  run.system.multiply_exactly(run.threads, run.x, product_);
  parallel::for_each(run.threads, run.b.size(), point_grain,
                     [&](std::size_t i) { residual_[i] = minus(run.b[i], product_[i]); });
  find_rigid_change(run);
}

/// residual = b - A x for the guess x, or for x = 0 if that is better. Returns |b|; if that is 0, sets x = 0.
double ConjugateGradients::start(Run& run) {
  const std::size_t points = run.b.size();
  const double squared_b = parallel::sum(run.threads, points, partial_sums_,
                                         [&](std::size_t i) { return dot(run.b[i], run.b[i]); });
  if (squared_b == 0.0) {
    std::fill(run.x.begin(), run.x.end(), simd::Padded3{});
    return 0.0;
  }
  const double squared_x = parallel::sum(run.threads, points, partial_sums_,
                                         [&](std::size_t i) { return dot(run.x[i], run.x[i]); });
  if (squared_x == 0.0) {  // no initial guess: the product is zero
    std::copy(run.b.begin(), run.b.end(), residual_.begin());
    find_rigid_change(run);
    return std::sqrt(squared_b);
  }
  find_residual(run);
  // Squared residual of zero minus the squared residual of the guess.
  const double gain = parallel::sum(run.threads, points, partial_sums_, [&](std::size_t i) {
    return dot(run.b[i], run.b[i]) - dot(residual_[i], residual_[i]);
  });
  if (!(gain >= 0.0)) {
    std::fill(run.x.begin(), run.x.end(), simd::Padded3{});
    std::copy(run.b.begin(), run.b.end(), residual_.begin());
    find_rigid_change(run);
  }
  return std::sqrt(squared_b);
}

/// Sets the float vectors from the true residual and the solution, scaled by a power of two, and their sums.
void ConjugateGradients::load(Run& run) {
  run.largest = std::sqrt(parallel::sum(run.threads, residual_.size(), partial_sums_,
                                        [&](std::size_t i) { return dot(residual_[i], residual_[i]); }));
  const double before = run.scale;
  run.scale =
      run.largest > 0.0 && std::isfinite(run.largest) ? std::ldexp(1.0, std::ilogb(run.largest)) : 1.0;
  const double inverse = 1.0 / run.scale;
  const auto ratio = static_cast<float>(before * inverse);
  const auto points = run.system.blocks().point_of_row();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    const auto point = static_cast<std::size_t>(points[row]);
    set_row(row_residual_, row, unpadded(residual_[point]), inverse);
    set_row(row_guess_, row, unpadded(run.x[point]), inverse);
    set_row(row_solution_, row, {});
    simd::Quad& p = direction_[row];
    p = {ratio * p.x, ratio * p.y, ratio * p.z, 0.0F};
  });
  run.sums = advance(run, 0.0);
  run.loaded_by_mass = run.sums.by_mass;
}

/// Drops the result of the iterations since the residual was last replaced.
void ConjugateGradients::discard(Run& run) {
  std::ranges::fill(row_solution_, 0.0F);
  std::ranges::fill(direction_, simd::Quad{});
  run.sums = advance(run, 0.0);
  clear_estimates();
}

/// Adds the result of the iterations to the solution.
void ConjugateGradients::flush(Run& run) {
  const auto points = run.system.blocks().point_of_row();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    simd::Padded3& x = at(run.x, points[row]);
    const Vec3 change = get_row(row_solution_, row, run.scale);
    x = {x.x + change.x, x.y + change.y, x.z + change.z, 0.0};
    set_row(row_solution_, row, {});
    set_row(row_guess_, row, unpadded(x), 1.0 / run.scale);
  });
}

/// Distance of the float residual from the true one, weighted by 1 / m.
double ConjugateGradients::drift(const Run& run) {
  const auto points = run.system.blocks().point_of_row();
  return std::sqrt(parallel::sum(run.threads, points.size(), partial_sums_, [&](std::size_t row) {
    if (points[row] < 0) return 0.0;
    const simd::Padded3 d = minus(at(residual_, points[row]), padded(get_row(row_residual_, row, run.scale)));
    return dot(d, d) / run.system.blocks().diagonal()[static_cast<std::size_t>(points[row])];
  }));
}

/// Norm of the current direction, by mass.
double ConjugateGradients::direction_size(const Run& run) {
  const auto masses = run.system.masses();
  return std::sqrt(parallel::sum(run.threads, masses.size(), partial_sums_, [&](std::size_t row) {
    const simd::Quad& p = direction_[row];
    return static_cast<double>(masses[row] * (p.x * p.x + p.y * p.y + p.z * p.z));
  }));
}

/// Norm of the current preconditioned residual, by mass.
double ConjugateGradients::preconditioned_size(const Run& run) {
  const auto masses = run.system.masses();
  return run.scale * std::sqrt(parallel::sum(run.threads, masses.size(), partial_sums_, [&](std::size_t row) {
           const Vec3 z = get_row(row_preconditioned_, row);
           return static_cast<double>(masses[row]) * dot(z, z);
         }));
}

simd::GradientVectors ConjugateGradients::vectors(const Run& run) {
  return {.solution = row_solution_.data(),
          .residual = row_residual_.data(),
          .preconditioned = row_preconditioned_.data(),
          .product = row_product_.data(),
          .direction = direction_.data(),
          .guess = row_guess_.data(),
          .inverse_diagonal = run.system.inverse_diagonal().data(),
          .masses = run.system.masses().data(),
          .inverse_masses = run.system.inverse_masses().data()};
}

simd::VectorSums ConjugateGradients::advance(const Run& run, double step) {
  const simd::GradientVectors all = vectors(run);
  parallel::for_chunks(run.threads, run.system.blocks().slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         partial_[chunk] = simd::advance_slices(all, static_cast<float>(step), begin, end);
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

void ConjugateGradients::next_direction(const Run& run, double beta) {
  const simd::GradientVectors all = vectors(run);
  parallel::for_chunks(run.threads, run.system.blocks().slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::update_directions(all, static_cast<float>(beta), begin, end);
                       });
}

/// product = A direction; returns direction^T A direction.
double ConjugateGradients::multiply(Run& run) {
  if (!run.exact_products) return run.system.multiply(run.threads, direction_, row_product_);
  const auto points = run.system.blocks().point_of_row();
  // The residual by point is not needed before the next check, so its memory is used here.
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    const simd::Quad& p = direction_[row];
    at(residual_, points[row]) = {static_cast<double>(p.x), static_cast<double>(p.y),
                                  static_cast<double>(p.z), 0.0};
  });
  run.system.multiply_exactly(run.threads, residual_, product_);
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] >= 0) set_row(row_product_, row, unpadded(at(product_, points[row])));
  });
  return parallel::sum(run.threads, points.size(), partial_sums_, [&](std::size_t row) {
    return points[row] < 0 ? 0.0 : dot(at(residual_, points[row]), at(product_, points[row]));
  });
}

void ConjugateGradients::resize(const LinearSystem& system) {
  residual_.resize(system.size());
  product_.resize(system.size());
  const std::size_t slices = system.blocks().slice_count();
  for (auto* vector : {&row_residual_, &row_preconditioned_, &row_product_, &row_solution_, &row_guess_}) {
    vector->assign(simd::slice_values * slices, 0.0F);
  }
  direction_.assign(simd::slice_rows * slices, simd::Quad{});
  partial_.resize(parallel::chunk_count(slices, slice_grain));
}

}  // namespace palpate::fem
