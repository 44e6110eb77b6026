// The error of ContactSolver: its estimates, and the true residual.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/contact_solver_run.hpp"

namespace palpate::fem {
namespace {

/// Iterations with multigrid after which a solve knows its error from the changes of the solution.
constexpr int informative = 20;
/// The largest of so many last changes counts, with multigrid.
constexpr std::size_t window = 3;
/// Safety factor of the error estimate from the last change (several inner iterations of block Jacobi).
constexpr double contact_safety = 2.0;

}  // namespace

void ContactSolver::begin_estimates(const Run& run) {
  estimate_.clear();
  change_estimate_.begin(run.report.multigrid ? window : 1);
}

/// Whether an estimate that the goal is reached is not reliable. Stiff bodies have errors that an iteration
/// of block Jacobi hardly changes, so they are missing in its estimate but not in the bound.
bool ContactSolver::must_change(const Run& run) {
  constexpr double reliable = 10.0;
  const bool may_change = run.change_at < std::numeric_limits<int>::max();
  return may_change && run.error_bound() > reliable * run.goal.tolerance * run.solution_unit();
}

/// Estimates residual and error from the iteration. A short solve with multigrid knows little of its rate of
/// convergence. So the error is at least half of what the residual meant in the last informative solve.
void ContactSolver::estimate_error(Run& run) const {
  run.report.relative_residual = 0.0;
  run.report.relative_error = 0.0;
  if (run.squares == 0.0) return;
  const double unit = std::max(residual_of_zero_, run.goal.least_residual);
  run.report.relative_residual = run.residual() / unit;
  double estimate = estimate_.error();
  if (run.report.multigrid) {
    estimate = change_estimate_.error();
    if (run.steps < informative)
      estimate = std::max(estimate, 0.5 * run.report.error_per_bound * run.error_bound());
  } else if (run.inner > 1) {
    estimate = contact_safety * change_estimate_.error();
  }
  run.report.relative_error = std::min(run.error_bound(), estimate) / run.solution_unit();
}

/// Stores which fraction of its bound the error was, if the solve knows it.
void ContactSolver::store_fraction(Run& run) {
  if (run.report.converged && run.report.multigrid && run.steps >= informative && run.by_mass > 0.0)
    run.report.error_per_bound = run.report.relative_error * run.solution_unit() / run.error_bound();
}

/// Adds the iterations' result to the solution and computes the true residual. Returns whether the float
/// residual was close to it.
bool ContactSolver::check_true_residual(Run& run) {
  ++run.residual_checks;
  flush(run);
  find_residual(run);
  const double ratio = run.scale;
  std::ranges::copy(residual_, preconditioned_.begin());
  load(run);
  if (run.goal.fixed_iterations == 0)
    run.rigid_change = run.problem.system->rigid_change(run.threads, with_contacts_, run.positions);
  compute_residual(run);
  const auto inverse_masses = run.problem.system->inverse_masses();
  const auto factor = static_cast<float>(ratio / run.scale);
  const double off =
      run.scale * std::sqrt(parallel::sum(run.threads, inverse_masses.size(), partial_, [&](std::size_t row) {
        double sum = 0.0;
        for (std::size_t e = 0; e < 3; ++e) {
          const std::size_t i = place_of(row) + simd::slice_rows * e;
          const auto d = static_cast<double>(residual_[i] - factor * preconditioned_[i]);
          sum += d * d;
        }
        return static_cast<double>(inverse_masses[row]) * sum;
      }));
  const bool near = off <= SolveGoal::drift * run.goal.tolerance * run.solution_unit();
  run.exact_products = run.exact_products || !near;
  return near;
}

/// Whether x is a worse result than zero. It is if it has more energy: x^T A x / 2 - x^T b + h sum_k
/// V_k(u_k), with the potentials V_k of the contacts for their friction bounds at x. A solution has the least
/// energy. Needs the true residual.
bool ContactSolver::is_worse_than_zero(const Run& run) {
  const double of_bodies = parallel::sum(run.threads, run.x.size(), partial_, [&](std::size_t i) {
    return -0.5 * (dot(unpadded(run.x[i]), unpadded(run.b[i])) +
                   dot(unpadded(run.x[i]), unpadded(true_residual_[i])));
  });
  const StepFriction& step = run.problem.friction;
  const auto contacts = run.contacts();
  const double of_contacts = parallel::sum(run.threads, contacts.size(), partial_, [&](std::size_t k) {
    const ContactLaw& law = run.problem.laws[k];
    const Vec3 u = run.relative_velocity(contacts[k]);
    const double bound = step.coefficient * contact_force(law, step, u).normal;
    return step.time_step *
           (contact_potential(law, step.time_step, bound, u) -
            contact_potential(law, step.time_step, bound, run.relative_velocity(contacts[k], 0.0)));
  });
  return !(of_bodies + of_contacts < 0.0) || (run.stiff && gains_speed(run));
}

/// Whether the bodies become faster than loads alone could make them. A failed solve of stiff bodies may
/// release energy that errors of earlier steps have stored as strain.
bool ContactSolver::gains_speed(const Run& run) {
  const auto masses = run.problem.system->blocks().diagonal();
  const auto size = [&](bool with_x) {
    return std::sqrt(parallel::sum(run.threads, run.x.size(), partial_, [&](std::size_t i) {
      const Vec3 base = unpadded(run.problem.base[i]);
      return run.problem.system->free()[i] == 0
                 ? 0.0
                 : masses[i] * squared_length(with_x ? base + unpadded(run.x[i]) : base);
    }));
  };
  return size(true) > size(false) + run.goal.load_scale;
}

}  // namespace palpate::fem
