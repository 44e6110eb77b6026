#include "fem/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

constexpr std::size_t slice_grain = 16;
constexpr std::size_t point_grain = 256;
/// Of the goal: what the estimate may take, and what the drift of the float residual from the true one may.
constexpr double estimated_share = 0.9;
constexpr double drift_share = 0.1;
/// A float residual that has become so much smaller has little left that is true.
constexpr double worn = 1e-5;
/// Iterations with the factor before there is an estimate: each lowers the error so much that two tell
/// enough.
constexpr std::size_t few = 2;

/// Iterations with the factor after which it does not help.
int most_of_factor(int patience) {
  constexpr int least = 30;
  return std::max(least, patience);
}

double dot(const simd::Padded3& a, const simd::Padded3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Of a row, in vectors by slices.
std::size_t place_of(std::size_t row) {
  return simd::slice_values * (row / simd::slice_rows) + row % simd::slice_rows;
}

void set(std::span<float> vector, std::size_t row, const simd::Padded3& value, double factor) {
  const std::size_t place = place_of(row);
  vector[place] = static_cast<float>(factor * value.x);
  vector[place + simd::slice_rows] = static_cast<float>(factor * value.y);
  vector[place + 2 * simd::slice_rows] = static_cast<float>(factor * value.z);
}

simd::Padded3 get(std::span<const float> vector, std::size_t row, double factor) {
  const std::size_t place = place_of(row);
  const auto value = [&](std::size_t k) {
    return factor * static_cast<double>(vector[place + simd::slice_rows * k]);
  };
  return {value(0), value(1), value(2), 0.0};
}

simd::Padded3 minus(const simd::Padded3& a, const simd::Padded3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z, 0.0};
}

}  // namespace

void ConjugateGradients::find_residual(const Run& run) {
  run.system.multiply_exactly(run.threads, run.x, product_);
  parallel::for_each(run.threads, run.b.size(), point_grain,
                     [&](std::size_t i) { residual_[i] = minus(run.b[i], product_[i]); });
}

/// residual = b - A x for the better of the guess and zero; returns |b|. Where that is 0, x = 0.
double ConjugateGradients::start(const Run& run) {
  const std::size_t points = run.b.size();
  const double squared_b = parallel::sum(run.threads, points, partial_sums_,
                                         [&](std::size_t i) { return dot(run.b[i], run.b[i]); });
  if (squared_b == 0.0) {
    std::fill(run.x.begin(), run.x.end(), simd::Padded3{});
    return 0.0;
  }
  const double squared_x = parallel::sum(run.threads, points, partial_sums_,
                                         [&](std::size_t i) { return dot(run.x[i], run.x[i]); });
  if (squared_x == 0.0) {  // no guess: what a product would say is known
    std::copy(run.b.begin(), run.b.end(), residual_.begin());
    return std::sqrt(squared_b);
  }
  find_residual(run);
  // Squared residual of the guess below that of zero by this much.
  const double gain = parallel::sum(run.threads, points, partial_sums_, [&](std::size_t i) {
    return dot(run.b[i], run.b[i]) - dot(residual_[i], residual_[i]);
  });
  if (!(gain >= 0.0)) {
    std::fill(run.x.begin(), run.x.end(), simd::Padded3{});
    std::copy(run.b.begin(), run.b.end(), residual_.begin());
  }
  return std::sqrt(squared_b);
}

/// The float vectors from the true residual and the solution as they are, scaled by a power of two.
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
    const auto point = static_cast<std::size_t>(points[row]);
    set(row_residual_, row, residual_[point], inverse);
    set(row_guess_, row, run.x[point], inverse);
    set(row_solution_, row, {}, 0.0);
    simd::Quad& p = direction_[row];
    p = {ratio * p.x, ratio * p.y, ratio * p.z, 0.0F};
  });
}

/// Adds what the iterations have found to the solution.
void ConjugateGradients::flush(Run& run) {
  const auto points = run.system.blocks().point_of_row();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    simd::Padded3& x = at(run.x, points[row]);
    const simd::Padded3 change = get(row_solution_, row, run.scale);
    x = {x.x + change.x, x.y + change.y, x.z + change.z, 0.0};
    set(row_solution_, row, {}, 0.0);
    set(row_guess_, row, x, 1.0 / run.scale);
  });
}

/// How far the float residual is from the true one, by 1 / m.
double ConjugateGradients::drift(const Run& run) {
  const auto points = run.system.blocks().point_of_row();
  return std::sqrt(parallel::sum(run.threads, points.size(), partial_sums_, [&](std::size_t row) {
    const simd::Padded3 d = minus(at(residual_, points[row]), get(row_residual_, row, run.scale));
    return dot(d, d) / run.system.blocks().diagonal()[static_cast<std::size_t>(points[row])];
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

void ConjugateGradients::turn(const Run& run, double turn) {
  const simd::GradientVectors all = vectors(run);
  parallel::for_chunks(run.threads, run.system.blocks().slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::turn_slices(all, static_cast<float>(turn), begin, end);
                       });
}

/// product = A direction; returns direction^T A direction.
double ConjugateGradients::multiply(Run& run) {
  if (!run.exact_products) return run.system.multiply(run.threads, direction_, row_product_);
  const auto points = run.system.blocks().point_of_row();
  // The residual by point is not needed before the next check.
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    const simd::Quad& p = direction_[row];
    at(residual_, points[row]) = {static_cast<double>(p.x), static_cast<double>(p.y),
                                  static_cast<double>(p.z), 0.0};
  });
  run.system.multiply_exactly(run.threads, residual_, product_);
  parallel::for_each(run.threads, points.size(), point_grain,
                     [&](std::size_t row) { set(row_product_, row, at(product_, points[row]), 1.0); });
  return parallel::sum(run.threads, points.size(), partial_sums_, [&](std::size_t row) {
    return dot(at(residual_, points[row]), at(product_, points[row]));
  });
}

/// How far the iterations are by their own account.
void ConjugateGradients::judge(const Run& run, SolveReport& report) const {
  const double residual = run.iterations_since == 0 ? run.largest : run.scale * std::sqrt(run.sums.residual);
  const double error = std::min(run.scale * std::sqrt(run.sums.by_mass), estimate_.error());
  report.relative_residual = residual / run.residual_unit();
  report.relative_error = error / run.solution_unit();
}

bool ConjugateGradients::reached(const SolveGoal& goal, const SolveReport& report, double share) {
  const double found = goal.of_solution ? report.relative_error : report.relative_residual;
  return found <= share * goal.tolerance;
}

/// Takes over the solution and looks at the true residual; returns whether the goal is reached.
bool ConjugateGradients::settle(Run& run, SolveReport& report) {
  flush(run);
  find_residual(run);
  const double off = drift(run);
  const double residual = std::sqrt(parallel::sum(run.threads, residual_.size(), partial_sums_,
                                                  [&](auto i) { return dot(residual_[i], residual_[i]); }));
  report.relative_residual = residual / run.residual_unit();
  report.relative_error += off / run.solution_unit();
  const bool near = off <= drift_share * run.goal.tolerance * run.solution_unit();
  run.exact_products = run.exact_products || (run.last_drift > 0.0 && !(off < 0.5 * run.last_drift));
  run.last_drift = off;
  run.direction_holds = off <= 0.1 * run.scale * std::sqrt(run.sums.by_mass);
  return reached(run.goal, report, 1.0) && (near || !run.goal.of_solution);
}

/// Puts the true residual in place of that of the iterations; returns what the next direction keeps of the
/// last.
double ConjugateGradients::replace(Run& run, const SolveReport& report) {
  load(run);
  run.sums = advance(run, 0.0);
  precondition(run, report);
  run.iterations_since = 0;
  const double now = run.scale * run.scale * run.sums.preconditioned;
  return run.direction_holds && run.last_preconditioned > 0.0 ? now / run.last_preconditioned : 0.0;
}

/// Makes of the residual preconditioned by block Jacobi what else there is.
void ConjugateGradients::precondition(Run& run, const SolveReport& report) {
  if (report.factor)
    run.sums.preconditioned = run.factor->apply(run.threads, row_residual_, row_preconditioned_);
  if (report.two_level)
    run.sums.preconditioned += run.coarse->correct(run.threads, row_residual_, row_preconditioned_);
}

/// What the solve begins with, and when it changes.
void ConjugateGradients::choose(Run& run, SolveReport& report) {
  constexpr int never = std::numeric_limits<int>::max();
  const auto factor_patience = [&]() -> std::optional<int> {
    return run.factor != nullptr ? run.factor->patience() : std::nullopt;
  };
  run.change_at = never;
  report.stage = run.goal.stage;
  if (run.coarse == nullptr || run.goal.preconditioner == Preconditioner::jacobi) return;
  if (run.goal.preconditioner == Preconditioner::two_level) report.stage = Stage::two_level;
  if (run.goal.preconditioner == Preconditioner::factor) report.stage = Stage::factor;
  const bool may_factor = report.stage <= Stage::factor && factor_patience().has_value();
  if (!may_factor && report.stage == Stage::factor) report.stage = Stage::two_level;
  if (!may_factor && report.stage == Stage::start) report.stage = Stage::jacobi;
  const bool automatic = run.goal.preconditioner == Preconditioner::automatic;
  switch (report.stage) {
    case Stage::start:
      run.change_at = *factor_patience();
      break;
    case Stage::factor:
      run.factor->update(run.threads, run.system.couplings(), run.positions);
      report.factor = true;
      if (automatic) run.change_at = most_of_factor(*factor_patience());
      break;
    case Stage::jacobi:
      run.change_at = patience(*run.coarse);
      break;
    case Stage::two_level:
      run.system.update_coarse(run.threads, *run.coarse, run.positions);
      report.two_level = true;
      break;
  }
}

/// The next preconditioner of automatic.
void ConjugateGradients::change(Run& run, SolveReport& report) {
  if (report.stage == Stage::start) {
    run.factor->update(run.threads, run.system.couplings(), run.positions);
    run.change_at = report.iterations + most_of_factor(*run.factor->patience());
    report.factor = true;
    report.stage = Stage::factor;
  } else {
    run.system.update_coarse(run.threads, *run.coarse, run.positions);
    run.change_at = std::numeric_limits<int>::max();
    report.factor = false;
    report.two_level = true;
    report.stage = report.stage == Stage::factor ? Stage::jacobi : Stage::two_level;
  }
  run.sums = advance(run, 0.0);
  precondition(run, report);
  run.looks_ahead = report.factor && run.system.couplings().size() == 0;
  estimate_.clear(run.looks_ahead ? few : 4);
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

SolveReport ConjugateGradients::solve(const parallel::Threads& threads, LinearSystem& system,
                                      std::span<const simd::Padded3> b, std::span<simd::Padded3> x,
                                      const SolveGoal& goal, CoarseSpace* coarse,
                                      std::span<const Vec3> positions, RestFactor* factor) {
  resize(system);
  Run run{.threads = threads,
          .system = system,
          .b = b,
          .x = x,
          .goal = goal,
          .coarse = coarse,
          .factor = factor,
          .positions = positions};
  run.size_b = start(run);
  if (run.size_b == 0.0) return {.stage = goal.stage, .converged = true};
  load(run);
  run.sums = advance(run, 0.0);
  estimate_.clear();
  SolveReport report{.stage = goal.stage};
  const bool fixed = goal.fixed_iterations > 0;
  const int most = fixed ? goal.fixed_iterations : goal.max_iterations;
  double turned = 0.0;
  double last_step = 0.0;
  bool broken = false;
  bool begun = false;
  while (true) {
    judge(run, report);
    const bool fresh = run.iterations_since == 0;
    const bool enough = fresh ? report.iterations == 0 || run.looks_ahead || run.bounded(report)
                              : run.looks_ahead || run.iterations_since >= 2;
    const bool done = !fixed && enough && reached(goal, report, fresh ? 1.0 : estimated_share);
    const bool ends = done || broken || report.iterations >= most || run.sums.residual == 0.0;
    const bool is_worn = !fresh && run.scale * std::sqrt(run.sums.residual) <= worn * run.largest;
    if (ends && (fresh || fixed)) break;
    if (!fixed && (ends || is_worn)) {
      if (settle(run, report) || report.iterations >= most) break;
      if (broken && run.exact_products) break;
      run.exact_products = run.exact_products || broken;
      broken = false;
      turned = replace(run, report);
      if (run.looks_ahead) estimate_.look_ahead(last_step * run.scale * run.scale * run.sums.preconditioned);
      continue;
    }
    if (!begun) {  // only here, as a good guess needs no preconditioner
      choose(run, report);
      precondition(run, report);
      run.looks_ahead = report.factor && system.couplings().size() == 0;
      if (run.looks_ahead) estimate_.clear(few);
      begun = true;
    } else if (report.iterations >= run.change_at) {
      change(run, report);
      turned = 0.0;  // the directions so far are conjugate in vain
    }
    turn(run, turned);
    const double curvature = multiply(run);
    const double before = run.sums.preconditioned;
    const double step = before / curvature;
    broken = !(curvature > 0.0) || !std::isfinite(step);
    if (broken) {
      if (fixed) break;
      continue;
    }
    last_step = step;
    run.last_preconditioned = run.scale * run.scale * before;
    estimate_.add(step * run.last_preconditioned);
    run.sums = advance(run, step);
    precondition(run, report);
    if (run.looks_ahead) estimate_.look_ahead(step * run.scale * run.scale * run.sums.preconditioned);
    turned = run.sums.preconditioned / before;
    ++report.iterations;
    ++run.iterations_since;
  }
  if (fixed) flush(run);
  report.converged = reached(goal, report, 1.0);
  return report;
}

}  // namespace palpate::fem
