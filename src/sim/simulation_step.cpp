#include <algorithm>
#include <cmath>
#include <limits>

#include <palpate/error.hpp>

#include "contact/detector_steps.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_state.hpp"
#include "stopwatch.hpp"

// A substep: forces, and the solve with speculative contacts.
namespace palpate {
namespace {

/// Fraction of the remaining time budget for a detection that may not be the last in its step.
constexpr double fraction_ahead = 0.5;

double total(const DetectionTimes& t) {
  return t.grid + t.contacts + t.border_edges + t.crossings + t.depth;
}

}  // namespace

/// Whether detection has a time budget.
bool Simulation::State::spends_time() const {
  return settings.detection.budget && settings.detection.budget->milliseconds;
}

/// The time budget.
double Simulation::State::budget_seconds() const {
  return 1e-3 * settings.detection.budget->milliseconds.value();
}

/// Fraction of the time budget that is left in this step; 1 if there is none.
double Simulation::State::budget_left() const {
  if (!spends_time()) return 1.0;
  constexpr double least = 0.01;  // every detection gets some time
  return std::max(1.0 - progress.detection_seconds / budget_seconds(), least);
}

/// Whether enough time is left for two detections: one at the predicted positions and one at the end of the
/// step.
bool Simulation::State::can_predict() const {
  if (!spends_time()) return true;
  return progress.complete && detector.least_seconds() < fraction_ahead * budget_left() * budget_seconds();
}

/// Detects contacts.
/// \param last  it is the last detection of the step, so it may use all of the remaining time budget
void Simulation::State::detect(std::span<const Vec3> positions, bool last) {
  detector.detect(positions, (last || !spends_time() ? 1.0 : fraction_ahead) * budget_left());
  metrics.detection = detector.counts();
  metrics.detection_seconds += detector.times();
  progress.detection_seconds += total(detector.times());
  progress.complete = metrics.detection.completeness == 1.0;
}

/// Goes back to the metrics of a step.
void Simulation::State::set_metrics(const StepMetrics& of) {
  metrics = of;
  progress.complete = of.detection.completeness == 1.0;
}

/// Sets the tension of fibres at a time, s.
void Simulation::State::activate_fibres(double time) {
  for (std::size_t m = 0; m < activations.size(); ++m) {
    activations[m] = factor_at(materials.all[m].fibres.activation, time);
  }
  dynamics.set_activations(activations);
}

/// Sets what is given at the end of the substep: activations and prescribed positions.
void Simulation::State::set_end() {
  activate_fibres(substep.end);
  dynamics.prescribe(prescribed.points(), prescribed.positions(threads, substep.end));
}

void Simulation::State::reset_counts() {
  progress.solves = 0;
  progress.may_stop = sweeps();
  progress.detection_seconds = 0.0;
  metrics.substeps = 1;
  metrics.solves = 0;
  metrics.solver_iterations = 0;
  metrics.detections = 0;
  metrics.looks_ahead = true;
  metrics.detection_seconds = {};
  metrics.forces_seconds = 0.0;
  metrics.solver_seconds = 0.0;
}

void Simulation::State::begin_step() {
  const auto positions = loads.presses() ? dynamics.deformed_positions(substep.length) : dynamics.positions();
  step_loads = loads.forces(bodies, positions, settings.gravity, substep.end);
  dynamics.begin_step(substep.length, settings.gravity, step_loads);
  progress.stopped_passes = 0;
  progress.iterations_with_stops = 0;
  progress.least_stops = std::numeric_limits<std::int64_t>::max();
  progress.failed_searches = 0;
  metrics.stopped_passes = 0;
  metrics.passes = 0;
}

/// One solve with the contacts found so far.
/// \param loose   enough to predict positions
/// \param steady  contacts are expected to keep their status
bool Simulation::State::solve(double tolerance, bool loose, bool steady) {
  constexpr double loose_tolerance = 0.03;
  constexpr int most = std::numeric_limits<int>::max();
  constexpr int last_means = 4;  // times the iterations, in substeps that may not be divided
  const SolverSettings& solver = settings.solver;
  const bool is_last = shortest_substep() < settings.time_step && !may_divide();
  if (dynamics.has_frames() || response.leaves_out())
    response.leave_out(threads, dynamics.excess_velocities(), std::span(couplings).subspan(first_contact));
  const fem::SolveReport report = dynamics.solve(
      contact_set(),
      {.tolerance = loose ? std::max(loose_tolerance, tolerance) : tolerance,
       .max_iterations =
           is_last ? last_means * std::min(solver.max_iterations, most / last_means) : solver.max_iterations,
       .of_solution = solver.tolerance_of == ToleranceOf::solution,
       .preconditioner = solver.preconditioner,
       .rough = loose,
       .fixed_iterations = solver.fixed_iterations.value_or(0)},
      steady);
  progress.solves += report.solves;
  metrics.solves = progress.solves;
  metrics.solver_iterations += report.iterations;
  if (progress.stopped_passes > 0) progress.iterations_with_stops += report.iterations;
  // Free fall does not count as a blow-up, however small the body is.
  const double fall =
      2.0 * length(settings.gravity) * static_cast<double>(metrics.step + 1) * settings.time_step;
  double allowed = settings.limits.max_speed ? max_speed : max_speed + fall;
  if (progress.stopped_passes > 0) allowed = std::min(allowed, progress.most_speed);
  dynamics.check_limits(allowed, settings.limits.inverted_time);
  return report.converged;
}

fem::ContactSet Simulation::State::contact_set() {
  return {.laws = response.laws(),
          .couplings = couplings,
          .first = first_contact,
          .friction = {.coefficient = response.friction(), .time_step = step_length()}};
}

/// Solve, detect at the predicted positions, add speculative contacts; repeat until none are new. A solve
/// that only has to predict positions is loose: the first after a step in which bodies met, and while new
/// contacts push harder than all acting ones. A solution may rotate the frames of bodies: the next solve is
/// for the new frames and the new contacts together. One for frames alone follows where no new contacts are
/// expected. When contacts have converged, solve again if the forces of the tissue are not those of its
/// linearisation, at first to a larger tolerance.
/// \param last  metrics of the step before
Simulation::State::Solution Simulation::State::solve_with_speculative_contacts(const StepMetrics& last) {
  constexpr int most_rotations = 8;
  constexpr double many = 1.0;
  const bool predicts = can_predict();
  metrics.looks_ahead = predicts;
  const bool fixed = settings.solver.fixed_iterations.has_value();
  bool loose = last.speculative_contacts > 0 && predicts && !fixed;
  // The search in rotated frames was probably made in the step before, too.
  const bool found_at_once = last.detections == 1 || (progress.searched && last.detections == 2);
  bool steady = (found_at_once || last.order == 2) && !fixed;
  const auto known = std::ssize(response.laws());
  bool settled = last.speculative_contacts == 0;  // no new contacts are expected
  int rotations = 0;                              // of frames, since the last new contacts
  bool searches_again = true;
  double tolerance = settings.solver.tolerance;
  Solution solution;
  while (true) {
    Stopwatch watch;
    solution.converged = solve(tolerance, loose, steady);
    const bool solves_again = progress.solves < most_solves(progress.stopped_passes > 0);
    bool rotated = dynamics.update_rotating_frames();
    if (rotated && (rotations == most_rotations || !solves_again)) {
      solution.converged = false;
      rotated = false;
    }
    metrics.solver_seconds += watch.lap();
    searches_again = can_predict() && solves_again;
    if (rotated && (settled || !searches_again)) {
      ++rotations;
      loose = false;
      continue;
    }
    detect(dynamics.end_positions(), !searches_again);
    ++metrics.detections;
    watch.lap();
    const double met = searches_again
                           ? response.add_speculative(threads, bodies, DetectorSteps::table(detector),
                                                      dynamics.end_positions(), dynamics.mean_velocities(),
                                                      normal_forces(), couplings)
                           : 0.0;
    const bool passes = met == 0.0 && !loose && !rotated && stop_passes();
    settled = met == 0.0 && !passes;
    rotations = settled ? rotations : 0;
    solution.speculative_contacts = std::ssize(response.laws()) - known;
    metrics.forces_seconds += watch.lap();
    solution.converged = solution.converged && !stops_fail();
    if (stops_fail() || (dynamics.is_second_order() && (passes || solution.speculative_contacts > 0)))
      return solution;  // the step will be undone
    const bool solved = settled && !loose && !rotated;
    if (solved) {
      const auto next =
          fixed ? std::nullopt : dynamics.relinearise_tissue(settings.solver.tolerance, tolerance);
      if (!next) break;
      tolerance = *next;
    }
    if (solved && !searches_again) {
      dynamics.end_where_linearised();
      solution.converged = false;
      break;
    }
    loose = met > many && !fixed;
    steady = steady && solved;
  }
  // A detection that had only half of the remaining time may have missed contacts that matter in the next
  // step. After one that had all of it, there is no time left, and another one would find less.
  if (searches_again && !progress.complete && spends_time()) {
    detect(dynamics.end_positions(), true);
    ++metrics.detections;
  }
  return solution;
}

/// Norm of the normal forces of the contacts at the last solution (root of their sum of squares), N.
double Simulation::State::normal_forces() const {
  double sum = 0.0;
  const auto laws = response.laws();
  for (std::size_t c = 0; c < laws.size(); ++c) {
    const double normal = dot(couplings[first_contact + c].force, laws[c].direction);
    sum += normal * normal;
  }
  return std::sqrt(sum);
}

/// Forces and the end of a substep, computed from the positions and velocities of `dynamics`.
Simulation::State::Solution Simulation::State::solve_step(const StepMetrics& last) {
  Stopwatch watch;
  progress.computed = false;
  couplings.clear();
  grabs.append(dynamics.positions(), dynamics.point_masses(), couplings);
  grab_couplings = couplings.size();
  dynamics.holds().append(step_length(), couplings);
  first_tie = couplings.size();
  ties.append(dynamics.positions(), couplings);
  first_contact = couplings.size();
  metrics.forces_seconds += watch.lap();
  begin_step();
  metrics.solver_seconds += watch.lap();
  if (sweeps()) swept.begin_step(dynamics.positions(), DetectorSteps::table(detector));
  const std::span<const Vec3> contact_positions = find_contacts();
  watch.lap();
  const double h = step_length();
  response.compute(threads, bodies, DetectorSteps::table(detector), contact_positions, dynamics.velocities(),
                   {.since = h * (last_length / substep.length), .ahead = h},
                   h * h * length(settings.gravity), couplings);
  progress.computed = true;
  if (progress.searched) {
    response.move_back(threads, contact_positions, dynamics.positions(),
                       std::span(couplings).subspan(first_contact));
  }
  first_speculative = first_contact + response.present();
  if (sweeps()) swept.list_soft_pairs(DetectorSteps::table(detector));
  metrics.forces_seconds += watch.lap();
  const Solution solution = solve_with_speculative_contacts(last);
  metrics.solver_converged = solution.converged;
  metrics.speculative_contacts = solution.speculative_contacts;
  return solution;
}

/// \param detected  the step began with a detection of its own; otherwise it uses the held table
void Simulation::State::undo_step(bool detected) {
  DetectorSteps::swap_back(detector);
  if (progress.computed) {
    if (!detected && !progress.searched) DetectorSteps::table(detector).undo_step();
    response.undo();
  }
  dynamics.cancel_step();
}

/// Tries a step of BDF2. Succeeds if bodies do not meet or pass within it and it converges; otherwise
/// restores the state before it.
bool Simulation::State::solve_second_order(const StepMetrics& last) {
  const bool may = settings.time_integration == TimeIntegration::bdf2 && last.speculative_contacts == 0 &&
                   last.solver_converged && !spends_time();
  if (!may || !dynamics.start_second_order(substep.length)) return false;
  DetectorSteps::hold(detector);
  const bool detects = detector.contacts().size() > 0 || detector.edge_contacts().size() > 0;
  if (detects) {
    try {
      detect(dynamics.positions(), false);
    } catch (const Error&) {
      DetectorSteps::swap_back(detector);
      dynamics.cancel_step();
      return false;
    }
    ++metrics.detections;
  }
  try {
    const Solution solution = solve_step(last);
    if (solution.speculative_contacts == 0 && solution.converged && progress.stopped_passes == 0) return true;
  } catch (const Error&) {
    // A step of implicit Euler may still succeed.
  }
  undo_step(detects);
  return false;
}

}  // namespace palpate
