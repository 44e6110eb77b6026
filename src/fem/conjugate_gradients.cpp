#include "fem/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

/// Fraction of the goal that the estimated error may be.
constexpr double estimated_fraction = 0.9;
/// Safety factor of the error estimate from the last change of the solution (multigrid).
constexpr double safety = 2.0;
/// If the float residual has fallen by this factor, few of its digits are correct.
constexpr double stale_below = 1e-5;
/// If the float residual has grown by this factor, rounding makes the iteration diverge.
constexpr double diverged_above = 1e4;

}  // namespace

/// Estimates residual and error from the recurrence.
void ConjugateGradients::estimate_error(const Run& run, SolveReport& report) const {
  const double residual = run.iterations_since == 0 ? run.largest : run.scale * std::sqrt(run.sums.residual);
  double estimate = report.multigrid ? safety * change_estimate_.error() : estimate_.error();
  if (report.multigrid && run.iterations_since == 0)
    estimate = safety * change_estimate_.before(run.next_change);
  const double error = std::min(run.scale * std::sqrt(run.sums.by_mass), estimate);
  report.relative_residual = residual / run.residual_unit();
  report.relative_error = error / run.solution_unit();
}

void ConjugateGradients::clear_estimates() {
  estimate_.clear();
  change_estimate_.begin(1);
}

/// Whether the error of the solution in the norm of A is larger than that of zero: x^T A x / 2 - x^T b, which
/// conjugate gradients minimise, is not negative. Needs the true residual.
bool ConjugateGradients::is_worse_than_zero(const Run& run) {
  const double twice = parallel::sum(run.threads, run.x.size(), partial_sums_, [&](std::size_t i) {
    return dot(run.x[i], run.b[i]) + dot(run.x[i], residual_[i]);
  });
  return !(twice > 0.0);
}

bool ConjugateGradients::diverges(const Run& run) {
  return !(run.sums.by_mass <= diverged_above * diverged_above * run.loaded_by_mass);
}

bool ConjugateGradients::reached(const SolveGoal& goal, const SolveReport& report, double fraction) {
  const double found = goal.of_solution ? report.relative_error : report.relative_residual;
  return found <= fraction * goal.tolerance;
}

/// Adds the iterations' result to the solution and computes the true residual. Returns whether the goal is
/// reached.
bool ConjugateGradients::check_true_residual(Run& run, SolveReport& report) {
  flush(run);
  find_residual(run);
  const double off = drift(run);
  const double residual = std::sqrt(parallel::sum(run.threads, residual_.size(), partial_sums_,
                                                  [&](auto i) { return dot(residual_[i], residual_[i]); }));
  report.relative_residual = residual / run.residual_unit();
  report.relative_error += off / run.solution_unit();
  const bool near = off <= SolveGoal::drift * run.goal.tolerance * run.solution_unit();
  run.exact_products = run.exact_products || (run.last_drift > 0.0 && !(off < 0.5 * run.last_drift));
  run.last_drift = off;
  if (!run.rigid_part_is_small()) clear_estimates();  // they were wrong
  run.direction_holds = off <= 0.1 * run.scale * std::sqrt(run.sums.by_mass);
  return reached(run.goal, report, 1.0) && (near || !run.goal.of_solution) && run.rigid_part_is_small();
}

/// Replaces the residual of the recurrence by the true one. Returns beta, the factor of the last direction in
/// the next one.
double ConjugateGradients::replace(Run& run, const SolveReport& report) {
  load(run);
  precondition(run, report);
  run.iterations_since = 0;
  if (report.multigrid) run.next_change = preconditioned_size(run);
  const double now = run.scale * run.scale * run.sums.preconditioned;
  return run.direction_holds && run.last_preconditioned > 0.0 ? now / run.last_preconditioned : 0.0;
}

/// Replaces the preconditioned residual of block Jacobi by that of multigrid.
void ConjugateGradients::precondition(Run& run, const SolveReport& report) {
  if (report.multigrid) {
    run.sums.preconditioned =
        run.multigrid->apply(run.threads, run.system, row_residual_, row_preconditioned_);
  }
}

int ConjugateGradients::patience(const LinearSystem& system) {
  // Products: cost of a typical solve with multigrid, with its setup. Those without contacts take up to 100;
  // with contacts, a larger number than this costs more in solves that need multigrid.
  constexpr double without_couplings = 60.0;
  constexpr double with_couplings = 25.0;
  constexpr double aggregate = 18.0;      // points
  constexpr double most_pairs = 64.0;     // pairs of aggregates that a coupling joins
  constexpr double blocks_a_pair = 80.0;  // cost of a pair on all levels
  const double blocks = static_cast<double>(system.blocks().value_bytes()) / (9.0 * sizeof(float));
  const double aggregates =
      static_cast<double>(std::ranges::count(system.free(), std::uint8_t{1})) / aggregate;
  const double pairs = std::min(most_pairs, aggregates * aggregates);
  if (system.couplings().size() == 0) return static_cast<int>(without_couplings);
  const double couplings = blocks_a_pair * pairs * static_cast<double>(system.couplings().size());
  return static_cast<int>(std::min(with_couplings + couplings / std::max(blocks, 1.0), 1e6));
}

bool ConjugateGradients::tries_jacobi(int failed, int most) {
  constexpr double growth = 1.5;  // since the last failure
  return most > growth * failed;
}

/// Chooses the first preconditioner, and the iteration at which to change to multigrid.
void ConjugateGradients::choose(Run& run, SolveReport& report) {
  run.change_at = std::numeric_limits<int>::max();
  if (run.multigrid == nullptr || run.goal.preconditioner == Preconditioner::jacobi) return;
  const bool automatic = run.goal.preconditioner == Preconditioner::automatic;
  // Leave enough iterations for multigrid below the maximum.
  const int most = std::min(patience(run.system), run.goal.max_iterations * 9 / 10);
  if (automatic && !run.stiff && tries_jacobi(report.jacobi_iterations, most)) {
    run.change_at = most;
  } else {
    run.multigrid->update(run.threads, run.system, run.positions);
    report.multigrid = true;
  }
}

bool ConjugateGradients::may_change(const Run& run) {
  return run.change_at < std::numeric_limits<int>::max();
}

/// Changes to multigrid during a solve.
void ConjugateGradients::change(Run& run, SolveReport& report) {
  run.multigrid->update(run.threads, run.system, run.positions);
  report.jacobi_iterations = run.change_at;
  run.change_at = std::numeric_limits<int>::max();
  report.multigrid = true;
  run.sums = advance(run, 0.0);
  precondition(run, report);
  clear_estimates();
}

SolveReport ConjugateGradients::solve(const parallel::Threads& threads, LinearSystem& system,
                                      std::span<const simd::Padded3> b, std::span<simd::Padded3> x,
                                      const SolveGoal& goal, Multigrid* multigrid,
                                      std::span<const Vec3> positions) {
  resize(system);
  Run run{.threads = threads,
          .system = system,
          .b = b,
          .x = x,
          .goal = goal,
          .multigrid = multigrid,
          .positions = positions};
  run.stiff = goal.fixed_iterations == 0 && !positions.empty() && system.needs_exact_products(threads);
  run.exact_products = run.stiff;
  run.size_b = start(run);
  if (run.size_b == 0.0) return {.jacobi_iterations = goal.jacobi_iterations, .converged = true};
  load(run);
  clear_estimates();
  SolveReport report{.jacobi_iterations = goal.jacobi_iterations};
  const bool fixed = goal.fixed_iterations > 0;
  const int most = fixed ? goal.fixed_iterations : goal.max_iterations;
  double beta = 0.0;
  bool broken = false;
  bool begun = false;
  while (true) {
    estimate_error(run, report);
    const bool fresh = run.iterations_since == 0;
    const bool enough =
        fresh ? report.iterations == 0 || report.multigrid || run.bounded(report) : run.iterations_since >= 2;
    const bool done = !fixed && enough && reached(goal, report, fresh ? 1.0 : estimated_fraction) &&
                      (!fresh || run.rigid_part_is_small());
    const bool ends = done || broken || report.iterations >= most || run.sums.residual == 0.0;
    const bool is_stale = !fresh && run.scale * std::sqrt(run.sums.residual) <= stale_below * run.largest;
    if (ends && (fresh || fixed)) break;
    if (!fixed && (ends || is_stale)) {
      if (check_true_residual(run, report) || report.iterations >= most) break;
      if (broken && run.exact_products && !may_change(run)) break;
      beta = replace(run, report);
      if (broken && run.exact_products) {
        change(run, report);
        beta = 0.0;
      }
      run.exact_products = run.exact_products || broken;
      broken = false;
      continue;
    }
    if (!begun) {  // not earlier: a good guess needs no preconditioner
      choose(run, report);
      precondition(run, report);
      begun = true;
    } else if (report.iterations >= run.change_at) {
      change(run, report);
      beta = 0.0;  // restart: the preconditioner changed
    }
    next_direction(run, beta);
    const double curvature = multiply(run);
    const double before = run.sums.preconditioned;
    const double step = before / curvature;
    broken = !(curvature > 0.0) || !std::isfinite(step);
    if (broken) {
      if (fixed) break;
      continue;
    }
    run.last_preconditioned = run.scale * run.scale * before;
    estimate_.add(step * run.last_preconditioned);
    if (report.multigrid) change_estimate_.add(run.scale * step * direction_size(run));
    run.sums = advance(run, step);
    ++report.iterations;
    ++run.iterations_since;
    if (!fixed && diverges(run)) {
      discard(run);
      broken = true;
      continue;
    }
    precondition(run, report);
    beta = run.sums.preconditioned / before;
  }
  if (fixed) flush(run);
  report.converged = reached(goal, report, 1.0) && (fixed || run.rigid_part_is_small());
  if (!report.converged && !fixed && is_worse_than_zero(run)) std::ranges::fill(x, simd::Padded3{});
  if (report.multigrid) multigrid->count(report.iterations);
  return report;
}

}  // namespace palpate::fem
