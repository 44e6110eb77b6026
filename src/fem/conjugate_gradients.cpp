#include "fem/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

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

}  // namespace

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
