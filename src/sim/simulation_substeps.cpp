#include <algorithm>

#include <palpate/error.hpp>

#include "contact/detector_steps.hpp"
#include "sim/simulation_path.hpp"
#include "sim/simulation_state.hpp"
#include "sim/unseen_passes.hpp"
#include "stopwatch.hpp"

// A step, divided into substeps where it does not converge.
namespace palpate {
namespace {

/// Angle of a body in a substep from which on it is divided, rad. Soft bodies that spin faster gain energy.
constexpr double most_rotation = 2.0;

/// Adds the work of an attempt at a substep, which may have failed.
void add_work(const StepMetrics& of, StepMetrics& sum) {
  sum.solves += of.solves;
  sum.detections += of.detections;
  sum.solver_iterations += of.solver_iterations;
  sum.detection_seconds += of.detection_seconds;
  sum.forces_seconds += of.forces_seconds;
  sum.solver_seconds += of.solver_seconds;
}

/// The metrics of substeps and of the next one together: the state is that at the end of the next.
StepMetrics joined(const StepMetrics& before, StepMetrics next) {
  add_work(before, next);
  next.substeps += before.substeps;
  next.speculative_contacts += before.speculative_contacts;
  next.stopped_passes += before.stopped_passes;
  next.passes += before.passes;
  next.thinnest = thinner(next.thinnest, before.thinnest);
  next.pairs_that_could_pass = std::max(next.pairs_that_could_pass, before.pairs_that_could_pass);
  next.looks_ahead = next.looks_ahead && before.looks_ahead;
  next.solver_converged = next.solver_converged && before.solver_converged;
  return next;
}

}  // namespace

/// Length below which substeps are not divided, s.
double Simulation::State::shortest_substep() const {
  const bool divides = !settings.solver.fixed_iterations && !spends_time();
  return divides ? settings.time_step / settings.solver.max_substeps : settings.time_step;
}

/// Ends the substep at its last solution.
void Simulation::State::finish_substep() {
  DetectorSteps::release(detector);
  Stopwatch watch;
  count_passes();
  collect_forces();
  grabs.collect_forces(std::span(couplings).first(grab_couplings), step_length(), dynamics.mean_velocities());
  dynamics.end_step({std::span(couplings).subspan(first_tie), std::span(step_forces.all()).subspan(first_tie),
                     first_contact - first_tie, std::span(couplings).first(first_tie)});
  const std::span<const Vec3> lacking = dynamics.frame_reactions();
  for (std::size_t p = 0; records_reactions && p < lacking.size(); ++p)
    reactions[p] += fem::along(dynamics.held_axes()[p], lacking[p]);
  if (records_path) path.emplace_back(dynamics.positions().begin(), dynamics.positions().end());
  last_length = substep.length;
  metrics.solver_seconds += watch.lap();
}

/// Solves the substep with implicit Euler. If it fails, restores the state before it.
/// \param may_divide  if it does not converge, rotates a body too far or throws an Error, the state is
/// restored, too, and false returned. Without it, this is so only where passes are stopped: if passes remain
/// and it does not converge (unless iterations are fixed), or if it throws an Error
bool Simulation::State::solve_substep(const StepMetrics& last, bool may_divide) {
  metrics.order = 1;
  DetectorSteps::hold(detector);
  bool solved = false;
  try {
    const bool converged = solve_step(last).converged;
    const bool passes_remain = progress.may_stop && progress.passes > 0;
    const bool must_converge = may_divide || (passes_remain && !settings.solver.fixed_iterations);
    const bool rotates_far = may_divide && dynamics.largest_rotation() > most_rotation;
    solved = !stops_fail() && !rotates_far && (converged || !must_converge);
  } catch (const Error&) {
    if (!may_divide && progress.stopped_passes == 0) {
      undo_substep();
      throw;
    }
  } catch (...) {
    undo_substep();
    throw;
  }
  if (!solved) {
    undo_substep();
    return false;
  }
  finish_substep();
  return true;
}

/// Solves the substep as solve_substep(). If it fails only because something is stopped from passing, it is
/// solved without that, and the passes are counted: a body that is moved through another one in a step cannot
/// be stopped. Substeps are tried first, unless the search is limited.
bool Simulation::State::try_substep(const StepMetrics& last, bool may_divide) {
  if (solve_substep(last, may_divide)) return true;
  if (may_divide && !is_limited(0)) return false;
  const StepMetrics failed = metrics;
  reset_counts();
  set_end();
  progress.may_stop = false;
  const bool solved = solve_substep(last, may_divide);
  add_work(failed, metrics);
  return solved;
}

void Simulation::State::undo_substep() {
  undo_step(false);
  activate_fibres(substep.end - substep.length);
}

/// Solves the two halves of the substep, which may be divided again. Returns the metrics of the last one.
/// \param last  metrics of the substep before
/// \param sum   of the substeps that are done
StepMetrics Simulation::State::divide(StepMetrics last, StepMetrics& sum) {
  add_work(metrics, sum);
  const Substep whole = substep;
  for (const double end : {whole.end - 0.5 * whole.length, whole.end}) {
    substep = {.end = end, .length = 0.5 * whole.length};
    reset_counts();
    set_end();
    if (try_substep(last, may_divide())) {
      last = metrics;
      sum = joined(sum, last);
    } else {
      last = divide(last, sum);
    }
  }
  return last;
}

/// A whole step, from forces to the contacts at the new positions. If it fails, the state is as before. If it
/// fails only when it is divided, it is solved as a whole again, and counts as not converged.
void Simulation::State::advance() {
  const StepMetrics last = metrics;
  const Substep whole{.end = static_cast<double>(metrics.step + 1) * settings.time_step,
                      .length = settings.time_step};
  substep = whole;
  path.clear();
  reset_counts();
  set_end();
  if (solve_second_order(last)) {
    metrics.order = 2;
    return finish_substep();
  }
  if (try_substep(last, may_divide())) return;
  const SavedState start = saved_state();
  StepMetrics sum;
  sum.substeps = 0;
  try {
    divide(last, sum);
    metrics = sum;
  } catch (const Error&) {
    copy_state(start);
    path.clear();
    set_metrics(last);
    substep = whole;
    reset_counts();
    set_end();
    try_substep(last, false);
    add_work(sum, metrics);
  } catch (...) {
    copy_state(start);
    throw;
  }
}

void SimulationPath::record(Simulation& simulation) {
  simulation.state_->records_path = true;
}
std::span<const std::vector<Vec3>> SimulationPath::of_last_step(const Simulation& simulation) {
  return simulation.state_->path;
}

}  // namespace palpate
