#include "fem/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/contact_solver_run.hpp"
#include "fem/grains.hpp"

namespace palpate::fem {
namespace {

/// Iterations after which the preconditioner is renewed with the current contacts.
constexpr int renewal = 16;
/// A solve that only predicts positions ends after this number of directions. Where many small bodies may
/// touch in a step, it would take hundreds, and most of its contacts are others in the next solve.
constexpr int most_in_rough = 50;
/// A solve that is limited by rounding ends after this number of checks of the true residual, unless products
/// are in double.
constexpr int max_residual_checks = 4;

/// Number of directions that fit into memory.
double most_by_memory(std::size_t rows) {
  constexpr double memory = 256e6;  // bytes
  return memory / (2.0 * 3.0 * sizeof(float) * static_cast<double>(rows));
}

}  // namespace

/// Number of directions: as many as fit into memory, and so few that the step in their span costs at most a
/// fixed fraction of the rest of an iteration.
std::size_t ContactSolver::most_directions(const Run& run) {
  constexpr double fraction = 0.3;
  constexpr double least = 6.0;
  constexpr double of_multigrid = 10.0;
  constexpr double of_jacobi = 2.0;  // products
  const auto bytes = static_cast<double>(run.problem.system->blocks().value_bytes());
  const double product = 18.0 * bytes / (9.0 * sizeof(float));  // operations
  const double iteration = product * (run.report.multigrid ? of_multigrid : of_jacobi);
  const auto contacts = static_cast<double>(run.problem.laws.size());
  const double by_cost = std::sqrt(fraction * iteration / (27.0 * contacts));
  return static_cast<std::size_t>(std::clamp(std::min(by_cost, most_by_memory(run.points().size())), least,
                                             static_cast<double>(ReducedStep::max_directions)));
}

/// Number of iterations that make a direction: as many as cost as much as a step in the span, up to a few.
/// One with multigrid, whose iterations cost more than the step.
int ContactSolver::inner_iterations(const Run& run) {
  constexpr double most = 4.0;         // with more, friction limits the use of a direction
  constexpr double directions = 24.0;  // typical
  // Operations, rounded from a profile.
  constexpr double of_contact_laws = 1500.0;  // a contact: laws and derivatives at a few velocities
  constexpr double of_rates = 60.0;           // a contact and direction
  constexpr double of_derivatives = 8.0;      // a contact and pair of directions; most have not changed
  constexpr double of_direction = 18.0;       // a row and direction
  constexpr double of_vectors = 60.0;         // a row, in an inner iteration
  constexpr double of_coupling = 150.0;       // in a product
  if (run.report.multigrid || run.goal.fixed_iterations > 0) return 1;
  const auto contacts = static_cast<double>(run.problem.laws.size());
  const auto rows = static_cast<double>(run.points().size());
  const auto bytes = static_cast<double>(run.problem.system->blocks().value_bytes());
  const double step = contacts * (of_contact_laws + directions * (of_rates + of_derivatives * directions)) +
                      of_direction * rows * directions;
  const double inner = 18.0 * bytes / (9.0 * sizeof(float)) + of_vectors * rows + of_coupling * contacts;
  return static_cast<int>(std::clamp(step / inner, 1.0, most));
}

/// Doubles the number of directions if the residual hardly falls, because with contacts, dropping directions
/// slows convergence most. Returns false if there are enough, or no more are allowed.
bool ContactSolver::grow(Run& run) {
  constexpr int window = 8;
  constexpr double slow = 0.9;  // a step that reduces the residual less is slow
  const int steps = run.steps - run.past;
  if (steps < window) return false;
  double expected = run.past_residual;
  for (int i = 0; i < steps; ++i) expected *= slow;
  run.past = run.steps;
  run.past_residual = run.residual();
  const double most =
      std::min(most_by_memory(run.points().size()), static_cast<double>(ReducedStep::max_directions));
  const std::size_t more = std::min(2 * reduced_.capacity(), static_cast<std::size_t>(most));
  if (run.past_residual <= expected || more <= reduced_.capacity()) return false;
  reduced_.increase_capacity(more);
  directions_.resize(more * values_);
  products_.resize(more * values_);
  return true;
}

/// Starts from the guess or from zero, whichever has the smaller residual, without directions. If `goes_on`,
/// starts from the last solution with its directions.
void ContactSolver::start(Run& run, bool goes_on) {
  find_residual(run);
  if (goes_on) return;
  std::ranges::copy(run.x, guess_kept_.begin());
  std::ranges::copy(true_residual_, residual_kept_.begin());
  const double of_guess = add_contacts(run);
  std::ranges::fill(run.x, simd::Padded3{});
  std::ranges::copy(run.b, true_residual_.begin());
  const double of_zero = add_contacts(run);
  const double of_b = std::sqrt(parallel::sum(run.threads, run.b.size(), partial_, [&](std::size_t i) {
    return squared_length(unpadded(run.b[i]));
  }));
  residual_of_zero_ = std::max(of_b, of_zero);
  if (of_guess <= of_zero) {
    std::ranges::copy(guess_kept_, run.x.begin());
    std::ranges::copy(residual_kept_, true_residual_.begin());
  }
  reduced_.begin(most_directions(run));
  directions_.resize(reduced_.capacity() * values_);
  products_.resize(reduced_.capacity() * values_);
}

/// Sets the float vectors and the contacts from x and the true residual.
void ContactSolver::restart(Run& run, bool keeps_directions) {
  if (!keeps_directions) reduced_.begin(reduced_.capacity());
  reduced_.set_contacts(run.problem.laws, run.problem.friction);
  for (std::size_t d = 0; d < reduced_.directions(); ++d) find_rates(run, d);
  load(run);
  begin_estimates(run);
}

/// Chooses the first preconditioner, and when to change to multigrid, as ConjugateGradients does. Where the
/// last solve of the step needed multigrid, a tighter one needs it too.
void ContactSolver::choose(Run& run, bool goes_on) {
  run.inner = inner_iterations(run);
  if (run.goal.preconditioner == Preconditioner::jacobi) return;
  const int most = std::min(ConjugateGradients::patience(*run.problem.stiffened),
                            run.inner * run.goal.max_iterations * 9 / 10);
  const bool keeps_multigrid = goes_on && multigrid_ && !run.goal.rough;
  if (run.goal.preconditioner == Preconditioner::automatic && !keeps_multigrid && !run.stiff &&
      ConjugateGradients::tries_jacobi(run.report.jacobi_iterations, most)) {
    run.change_at = most;
  } else {
    run.report.multigrid = true;
    run.inner = 1;
  }
}

void ContactSolver::change_preconditioner(Run& run) {
  // A loose solve whose error is not known says little of the others.
  const int failed = run.goal.rough ? run.report.iterations : run.change_at;
  run.report.jacobi_iterations = std::max(run.report.jacobi_iterations, std::min(failed, run.change_at));
  run.change_at = std::numeric_limits<int>::max();
  run.report.multigrid = true;
  run.inner = 1;
  renew_preconditioner(run);
  begin_estimates(run);
}

/// Renews the preconditioner with the current contacts. Keeps the directions.
void ContactSolver::renew_preconditioner(Run& run) {
  run.renew_at = run.report.iterations + renewal;
  const auto contacts = run.contacts();
  parallel::for_each(run.threads, contacts.size(), contact_grain, [&](std::size_t k) {
    linearise(run.problem.laws[k], run.problem.friction, reduced_.velocity(k), contacts[k]);
  });
  LinearSystem& system = *run.problem.stiffened;
  system.couplings().set(run.threads, run.problem.couplings, run.problem.friction.time_step, system.free());
  system.update_preconditioner(run.threads);
  if (!run.report.multigrid) return;
  run.multigrid.begin_step();
  run.multigrid.update(run.threads, system, run.positions);
}

/// Brings the preconditioner up to date at the start of an iteration.
void ContactSolver::keep_current(Run& run) {
  const bool first = run.steps == 0;
  if (run.report.iterations >= run.change_at) {
    change_preconditioner(run);
  } else if (first) {
    run.renew_at = run.report.iterations + renewal;
    if (run.report.multigrid) run.multigrid.update(run.threads, *run.problem.stiffened, run.positions);
  } else if (run.report.iterations >= run.renew_at) {
    renew_preconditioner(run);
  }
}

/// Makes the next direction, and counts its iterations.
void ContactSolver::precondition(Run& run) {
  if (run.inner > 1) {
    constexpr double reduction = 0.1;  // contacts limit the use of a more exact direction
    constexpr double enough = 0.3;     // of what the goal needs
    const double needed =
        enough * run.goal.tolerance / std::max(run.report.relative_error, run.goal.tolerance);
    run.report.iterations += inner_.apply(run.threads, *run.problem.stiffened, residual_, preconditioned_,
                                          run.inner, std::max(reduction, needed));
    return;
  }
  ++run.report.iterations;
  if (run.report.multigrid) {
    run.multigrid.apply(run.threads, *run.problem.stiffened, residual_, preconditioned_);
    return;
  }
  const auto inverse = run.problem.stiffened->inverse_diagonal();
  constexpr std::size_t n = simd::slice_rows;
  parallel::for_each(run.threads, values_ / simd::slice_values, slice_grain, [&](std::size_t slice) {
    const float* d = &inverse[simd::slice_symmetric * slice];
    const float* from = &residual_[simd::slice_values * slice];
    float* to = &preconditioned_[simd::slice_values * slice];
    for (std::size_t lane = 0; lane < n; ++lane) {
      const float x = from[lane];
      const float y = from[n + lane];
      const float z = from[2 * n + lane];
      to[lane] = d[lane] * x + d[3 * n + lane] * y + d[4 * n + lane] * z;
      to[n + lane] = d[3 * n + lane] * x + d[n + lane] * y + d[5 * n + lane] * z;
      to[2 * n + lane] = d[4 * n + lane] * x + d[5 * n + lane] * y + d[2 * n + lane] * z;
    }
  });
}

/// Solves the problem in the span of the directions, and adds the step to the error estimates.
void ContactSolver::apply_step(Run& run) {
  run.broken = !reduced_.solve(run.threads);
  const auto c = reduced_.solution();
  const auto change = reduced_.change();
  double squared_change = 0.0;
  double squared_size = run.guess_by_mass;
  for (std::size_t i = 0; i < c.size(); ++i) {
    double of_change = 0.0;
    double of_c = 0.0;
    for (std::size_t j = 0; j < c.size(); ++j) {
      of_change += mass(i, j) * change[j];
      of_c += mass(i, j) * c[j];
    }
    squared_change += change[i] * of_change;
    squared_size += c[i] * (of_c + 2.0 * of_guess_[i]);
  }
  run.size = std::sqrt(std::max(squared_size, 0.0));
  if (run.broken) return;
  change_estimate_.add(std::sqrt(std::max(squared_change, 0.0)));
  estimate_.add(std::max(change.back() * run.decrease, 0.0));
}

SolveReport ContactSolver::solve(const parallel::Threads& threads, const ContactProblem& problem,
                                 std::span<const simd::Padded3> b, std::span<simd::Padded3> x,
                                 const SolveGoal& goal, Multigrid& multigrid, std::span<const Vec3> positions,
                                 bool goes_on) {
  Run run{.threads = threads,
          .problem = problem,
          .b = b,
          .x = x,
          .goal = goal,
          .multigrid = multigrid,
          .positions = positions};
  run.report.jacobi_iterations = goal.jacobi_iterations;
  run.report.error_per_bound = goal.error_per_bound;
  resize(run);
  run.stiff = goal.fixed_iterations == 0 && problem.system->needs_exact_products(threads);
  run.exact_products = run.stiff;
  choose(run, goes_on);
  start(run, goes_on);
  restart(run, true);
  run.size = std::sqrt(run.guess_by_mass);
  if (reduced_.directions() > 0) reduced_.solve(threads);  // the directions of the last call
  compute_residual(run);
  run.past_residual = run.residual();
  const bool fixed = goal.fixed_iterations > 0;
  const int allowed = goal.rough ? std::min(most_in_rough, goal.max_iterations) : goal.max_iterations;
  const int most = fixed ? goal.fixed_iterations : allowed;
  const int most_checks = run.stiff ? most : max_residual_checks;
  while (true) {
    estimate_error(run);
    if (!fixed && run.reached() && must_change(run)) {
      change_preconditioner(run);
      estimate_error(run);
    }
    if ((!fixed && run.reached()) || run.steps >= most) {
      const bool near = check_true_residual(run);
      estimate_error(run);
      // The true residual may be slightly above the goal although the float residual was below it.
      const bool done = near && (fixed || (run.reached() && run.rigid_part_is_small()));
      if (!run.rigid_part_is_small()) {
        begin_estimates(run);  // they were wrong
        --run.residual_checks;
      }
      if (done || run.residual_checks >= most_checks || run.steps >= most) break;
    }
    keep_current(run);
    if (reduced_.directions() == reduced_.capacity() && !grow(run)) shrink(run);
    precondition(run);
    if (!add_direction(run)) {
      check_true_residual(run);
      estimate_error(run);
      break;
    }
    apply_step(run);
    ++run.steps;
    if (run.broken) {
      // Rounding has made the directions linearly dependent: restart with the true residual.
      run.exact_products = true;
      flush(run);
      find_residual(run);
      restart(run, false);
    }
    compute_residual(run);
  }
  run.report.converged = run.reached() && (fixed || run.rigid_part_is_small());
  store_fraction(run);
  if (!run.report.converged && is_worse_than_zero(run)) {
    // Rounding prevents a solution, as with tissue whose stiffness is far larger than its inertia.
    std::ranges::fill(x, simd::Padded3{});
    reduced_.begin(reduced_.capacity());
  }
  multigrid_ = run.report.multigrid;
  // Even with a good hierarchy, a nonlinear solve takes about three times the iterations of a linear one.
  if (run.report.multigrid) multigrid.count(run.steps / 3);
  return run.report;
}

}  // namespace palpate::fem
