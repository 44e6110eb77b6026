#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "contact/detector_steps.hpp"
#include "fem/lumping.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "room.hpp"
#include "sim/model_check.hpp"
#include "sim/simulation_state.hpp"
#include "sim/state_hash.hpp"
#include "stopwatch.hpp"

namespace palpate {
namespace {

/// Fraction of the remaining time budget for a detection that may not be the last of its step.
constexpr double fraction_ahead = 0.5;

void check(bool right, const char* key, double found, const char* expected) {
  if (!right || !std::isfinite(found)) throw Error("simulation settings", key, number_text(found), expected);
}

const SimulationSettings& checked(const SimulationSettings& s) {
  check(s.time_step > 0.0, "time_step", s.time_step, "a finite number > 0");
  check(is_finite(s.gravity), "gravity", s.gravity.x + s.gravity.y + s.gravity.z, "three finite numbers");
  check(s.solver.tolerance > 0.0, "solver.tolerance", s.solver.tolerance, "a finite number > 0");
  check(s.solver.max_iterations > 0, "solver.max_iterations", s.solver.max_iterations, "at least 1");
  const int fixed = s.solver.fixed_iterations.value_or(1);
  check(fixed > 0, "solver.fixed_iterations", fixed, "at least 1");
  check(s.solver.max_solves > 0, "solver.max_solves", s.solver.max_solves, "at least 1");
  check(s.rest.speed > 0.0, "rest.speed", s.rest.speed, "a finite number > 0");
  check(s.rest.time > 0.0, "rest.time", s.rest.time, "a finite number > 0");
  const double max_speed = s.limits.max_speed.value_or(1.0);
  check(max_speed > 0.0, "limits.max_speed", max_speed, "a finite number > 0");
  const double inverted_time = s.limits.inverted_time.value_or(1.0);
  check(inverted_time > 0.0, "limits.inverted_time", inverted_time, "a finite number > 0");
  return s;
}

double total(const DetectionTimes& t) {
  return t.grid + t.contacts + t.border_edges + t.crossings + t.depth;
}

/// The limit of LimitSettings, or its default.
double speed_limit(const Bodies& bodies, const SimulationSettings& settings) {
  constexpr double diagonals = 100.0;
  if (settings.limits.max_speed || bodies.points_rest().empty())
    return settings.limits.max_speed.value_or(std::numeric_limits<double>::max());
  Vec3 lower = bodies.points_rest().front();
  Vec3 upper = lower;
  for (const Vec3& p : bodies.points_rest()) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  return diagonals * length(upper - lower) / settings.time_step;
}

}  // namespace

SimulationCore::SimulationCore(Model model, const SimulationSettings& settings,
                               const parallel::Threads& threads)
    : fingerprint(fingerprint_of(model, settings)),
      held{.holds = holds_of(model), .motions = std::move(model.motions)},
      loads(loads_of(model)),
      bodies(std::move(model.bodies)),
      materials(std::move(model.materials), std::move(model.material_of_tet), std::move(model.fibre_of_tet)) {
  PrescribedMotions prescribed(held.motions, held.holds.motion_of_point, bodies.points_rest());
  held.holds.ties = held_ties(model.ties, bodies, prescribed.start_positions(threads, bodies.points_rest()));
}

Simulation::State::State(std::shared_ptr<const SimulationCore> the_core, HeldModel held, LoadSet load_set,
                         const SimulationSettings& s, int n)
    : core(std::move(the_core)),
      bodies(core->bodies),
      materials(core->materials),
      holds(std::move(held.holds)),
      obstacles(rigid_bodies(holds)),
      settings(checked(s)),
      threads(n),
      prescribed(std::move(held.motions), motions_of_present(holds, bodies), holds.prescribed_start),
      dynamics(bodies, materials, unfree_points(holds, bodies), obstacles, threads),
      loads(std::move(load_set), bodies, holds.obstacles, dynamics.point_masses()),
      grabs(static_cast<Index>(bodies.points_rest().size())),
      detector(bodies, without_absent(settings.detection, holds.absent), obstacles, n),
      contact_materials(fem::mean_materials(bodies, materials)),
      response(bodies, contact_materials, obstacles, settings.response, dynamics.point_masses(),
               dynamics.free_points()),
      swept(bodies),
      max_speed(speed_limit(bodies, settings)),
      contact_forces(bodies.bodies().size()),
      masses(bodies.bodies().size(), 0.0),
      squared_speeds(bodies.bodies().size(), 0.0) {
  for (std::size_t p = 0; p < dynamics.point_masses().size(); ++p) {
    at(masses, bodies.body_of_point()[p]) += dynamics.point_masses()[p];
  }
  activations.resize(materials.all.size());
  activate_fibres(0.0);
  dynamics.set_fixed_axes(bodies, materials, holds.fixed_axes);
  dynamics.set_positions(prescribed.start_positions(threads, bodies.points_rest()));
  ties = Ties(holds.ties, bodies, dynamics.point_masses(), dynamics.free_points(), response);
  step_forces.set({}, std::vector<Vec3>(holds.ties.size()));
  response.use_edges(DetectorSteps::normals(detector));
}

void Simulation::State::start(const std::vector<Vec3>& velocities, const std::vector<Grab>& all_grabs) {
  for (const Grab& grab : all_grabs) grabs.add(grab);
  if (!velocities.empty()) dynamics.set_velocities(velocities);
  detect(dynamics.positions(), true);
  measure();
}

/// Whether detection has a time budget.
bool Simulation::State::spends_time() const {
  return settings.detection.budget && settings.detection.budget->milliseconds;
}

/// The time budget.
double Simulation::State::budget_seconds() const {
  return 1e-3 * settings.detection.budget->milliseconds.value();
}

/// Fraction of the time budget that is left in this step; 1 without a time budget.
double Simulation::State::budget_left() const {
  if (!spends_time()) return 1.0;
  constexpr double least = 0.01;  // every detection gets some time
  return std::max(1.0 - total(metrics.detection_seconds) / budget_seconds(), least);
}

/// Whether time is left for two detections: one at the predicted positions and one at the end of the step.
bool Simulation::State::can_predict() const {
  if (!spends_time()) return true;
  return metrics.detection.completeness == 1.0 &&
         detector.least_seconds() < fraction_ahead * budget_left() * budget_seconds();
}

/// \param last  it is the last of the step, so it may use all of the time budget
void Simulation::State::detect(std::span<const Vec3> positions, bool last) {
  detector.detect(positions, (last || !spends_time() ? 1.0 : fraction_ahead) * budget_left());
  metrics.detection = detector.counts();
  metrics.detection_seconds += detector.times();
}

/// Energies and extremes at the end of a step.
void Simulation::State::measure() {
  metrics.kinetic_energy = dynamics.kinetic_energy();
  metrics.elastic_energy = dynamics.elastic_energy();
  metrics.inverted_tets = dynamics.inverted_elements();
  double fastest = 0.0;
  std::fill(squared_speeds.begin(), squared_speeds.end(), 0.0);
  for (std::size_t p = 0; p < dynamics.velocities().size(); ++p) {
    if (dynamics.free_points()[p] == 0) continue;
    const double v2 = squared_length(dynamics.velocities()[p]);
    fastest = std::max(fastest, v2);
    at(squared_speeds, bodies.body_of_point()[p]) += dynamics.point_masses()[p] * v2;
  }
  metrics.largest_speed = std::sqrt(fastest);
  metrics.fastest_body = 0.0;
  for (std::size_t b = 0; b < masses.size(); ++b) {
    metrics.fastest_body = std::max(metrics.fastest_body, std::sqrt(squared_speeds[b] / masses[b]));
  }
  metrics.deepest = deepest();
}

double Simulation::State::deepest() {
  const Contacts& contacts = detector.contacts();
  double deepest = contacts.size() > 0 ? std::ranges::max(contacts.depth) : 0.0;
  const EdgeContacts& edges = detector.edge_contacts();
  if (edges.size() == 0) return deepest;
  using Pair = std::pair<Index, Index>;
  const auto pair_of = [](Index a, Index b) { return Pair(std::min(a, b), std::max(a, b)); };
  touching.clear();
  make_room(touching, contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Pair pair = pair_of(at(bodies.body_of_point(), contacts.point[c]), contacts.body[c]);
    if (touching.empty() || touching.back() != pair) touching.push_back(pair);
  }
  std::ranges::sort(touching);
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const Index own = bodies.body_of(at(bodies.edges(), edges.edge[c]));
    if (!std::ranges::binary_search(touching, pair_of(own, edges.body[c])))
      deepest = std::max(deepest, edges.depth[c]);
  }
  return deepest;
}

/// Sets the tension of fibres at a time, s.
void Simulation::State::activate_fibres(double time) {
  for (std::size_t m = 0; m < activations.size(); ++m) {
    activations[m] = factor_at(materials.all[m].fibres.activation, time);
  }
  dynamics.set_activations(activations);
}

void Simulation::State::begin_step() {
  const double end = static_cast<double>(metrics.step + 1) * settings.time_step;
  activate_fibres(end);
  dynamics.prescribe(prescribed.points(), prescribed.positions(threads, end));
  step_loads = loads.forces(bodies, dynamics.positions(), settings.gravity, end);
  dynamics.begin_step(settings.time_step, settings.gravity, step_loads);
  metrics.solves = 0;
  metrics.solver_iterations = 0;
  metrics.solver_converged = true;
  metrics.detections = 0;
  metrics.speculative_contacts = 0;
  metrics.stopped_passes = 0;
  metrics.passes = 0;
  swept.begin_step();
  metrics.looks_ahead = true;
  metrics.detection_seconds = {};
}

/// One solve with the contacts found so far.
/// \param loose   with a larger tolerance: enough to predict positions
/// \param steady  contacts are expected to keep their status
bool Simulation::State::solve(bool loose, bool steady) {
  constexpr double loose_tolerance = 0.03;
  const SolverSettings& solver = settings.solver;
  const fem::SolveReport report =
      dynamics.solve(contact_set(),
                     {.tolerance = loose ? std::max(loose_tolerance, solver.tolerance) : solver.tolerance,
                      .max_iterations = solver.max_iterations,
                      .of_solution = solver.tolerance_of == ToleranceOf::solution,
                      .preconditioner = solver.preconditioner,
                      .fixed_iterations = solver.fixed_iterations.value_or(0)},
                     steady);
  metrics.solves += report.solves;
  metrics.solver_iterations += report.iterations;
  // Free fall is no blow-up, however small the body.
  const double fall =
      2.0 * length(settings.gravity) * static_cast<double>(metrics.step + 1) * settings.time_step;
  const double allowed = settings.limits.max_speed ? max_speed : max_speed + fall;
  dynamics.check_limits(allowed, settings.limits.inverted_time);
  return report.converged;
}

fem::ContactSet Simulation::State::contact_set() {
  return {.laws = response.laws(),
          .couplings = couplings,
          .first = first_contact,
          .friction = {.coefficient = response.friction(), .time_step = settings.time_step}};
}

/// Solve, detect at the predicted positions, add speculative contacts; repeat until none are new. A solve
/// that only has to predict positions is loose: the first after a step in which bodies met, and while new
/// contacts push harder than all acting ones. When contacts have converged, solve again if the forces of the
/// tissue are not those of its linearisation.
/// \param last  metrics of the step before
void Simulation::State::solve_with_speculative_contacts(const StepMetrics& last) {
  constexpr int max_rotation_solves = 8;
  constexpr double many = 1.0;
  metrics.looks_ahead = can_predict();
  const bool fixed = settings.solver.fixed_iterations.has_value();
  bool loose = last.speculative_contacts > 0 && metrics.looks_ahead && !fixed;
  bool steady = last.detections == 1 && !fixed;
  const auto known = std::ssize(response.laws());
  while (true) {
    Stopwatch watch;
    metrics.solver_converged = solve(loose, steady);
    for (int i = 0; dynamics.follow_rotations(); ++i) {
      if (i == max_rotation_solves || metrics.solves >= most_solves(metrics.stopped_passes > 0)) {
        metrics.solver_converged = false;
        break;
      }
      metrics.solver_converged = solve(loose, steady);
    }
    metrics.solver_seconds += watch.lap();
    const bool searches_again = can_predict() && metrics.solves < most_solves(metrics.stopped_passes > 0);
    detect(dynamics.end_positions(), !searches_again);
    ++metrics.detections;
    watch.lap();
    const double met = searches_again
                           ? response.add_speculative(threads, bodies, DetectorSteps::table(detector),
                                                      dynamics.end_positions(), dynamics.mean_velocities(),
                                                      normal_forces(), couplings)
                           : 0.0;
    const bool passes = met == 0.0 && !loose && stop_passes();
    metrics.speculative_contacts = std::ssize(response.laws()) - known;
    metrics.forces_seconds += watch.lap();
    const bool solved = met == 0.0 && !passes && !loose;
    if (solved && (fixed || !dynamics.follow_tissue(settings.solver.tolerance))) break;
    if (solved && !searches_again) {
      dynamics.end_where_linearised();
      metrics.solver_converged = false;
      break;
    }
    loose = met > many && !fixed;
    steady = steady && solved;
  }
  // This detection had only half of the remaining time, so it may have missed contacts of the next step.
  if (metrics.detection.completeness < 1.0 && spends_time()) {
    detect(dynamics.end_positions(), true);
    ++metrics.detections;
  }
}

/// Normal forces of the contacts at the last solution, root of their sum of squares, N.
double Simulation::State::normal_forces() const {
  double sum = 0.0;
  const auto laws = response.laws();
  for (std::size_t c = 0; c < laws.size(); ++c) {
    const double normal = dot(couplings[first_contact + c].force, laws[c].direction);
    sum += normal * normal;
  }
  return std::sqrt(sum);
}

Simulation::Simulation(Model model, const SimulationSettings& settings, int threads) {
  const std::vector<Vec3> velocities = std::move(model.velocities);
  const std::vector<Grab> grabs = std::move(model.grabs);
  const auto core =
      std::make_shared<const SimulationCore>(std::move(model), settings, parallel::Threads(threads));
  state_ = std::make_unique<State>(core, core->held, core->loads, settings, threads);
  state_->start(velocities, grabs);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

/// A step, from forces to the contacts at the new positions. If it fails, the state is unchanged.
void Simulation::State::advance() {
  Stopwatch watch;
  const StepMetrics last = metrics;
  couplings.clear();
  grabs.append(dynamics.positions(), dynamics.point_masses(), couplings);
  grab_couplings = couplings.size();
  dynamics.holds().append(settings.time_step, couplings);
  first_tie = couplings.size();
  ties.append(dynamics.positions(), couplings);
  first_contact = couplings.size();
  DetectorSteps::hold(detector);
  const double h = settings.time_step;
  response.compute(threads, bodies, DetectorSteps::table(detector), dynamics.positions(),
                   dynamics.velocities(), h, h * h * length(settings.gravity), couplings);
  first_speculative = first_contact + response.present();
  metrics.forces_seconds = watch.lap();
  try {
    begin_step();
    metrics.solver_seconds = watch.lap();
    solve_with_speculative_contacts(last);
  } catch (...) {
    DetectorSteps::swap_back(detector);
    DetectorSteps::table(detector).undo_step();
    response.undo();
    throw;
  }
  DetectorSteps::release(detector);
  watch.lap();
  count_passes();
  collect_forces();
  grabs.collect_forces(std::span(couplings).first(grab_couplings), settings.time_step,
                       dynamics.mean_velocities());
  dynamics.end_step();
  metrics.solver_seconds += watch.lap();
}

const StepMetrics& Simulation::step() {
  State& s = *state_;
  const StepMetrics last = s.metrics;
  try {
    s.advance();
  } catch (const Error& error) {
    s.metrics = last;
    const std::string step = "step " + std::to_string(last.step + 1);
    const std::string where = error.where().empty() ? step : error.where() + ", " + step;
    throw Error(error.source(), where, error.found(), error.expected());
  }
  ++s.metrics.step;
  s.metrics.time = static_cast<double>(s.metrics.step) * s.settings.time_step;
  s.measure();
  const bool slow = s.metrics.fastest_body <= s.settings.rest.speed && s.metrics.time >= s.prescribed.end();
  s.slow_steps = slow ? s.slow_steps + 1 : 0;
  return s.metrics;
}

void Simulation::change(const SimulationSettings& settings) {
  State& s = *state_;
  checked(settings);
  ContactResponse::check_settings(settings.response);
  if (settings.time_step != s.settings.time_step) {
    throw Error("simulation settings", "time_step", number_text(settings.time_step),
                number_text(s.settings.time_step) + ", as it is: steps are counted in it");
  }
  if (settings.detection != s.settings.detection) {
    Detector detector(s.bodies, without_absent(settings.detection, s.holds.absent), s.obstacles,
                      s.threads.count());
    detector.detect(s.dynamics.positions());
    DetectorSteps::table(detector).set_history(DetectorSteps::table(s.detector).history());
    s.detector = std::move(detector);
  }
  s.response.change(settings.response);
  s.response.use_edges(DetectorSteps::normals(s.detector));
  s.settings = settings;
  s.max_speed = speed_limit(s.bodies, settings);
  s.slow_steps = 0;
}

const Bodies& Simulation::bodies() const {
  return state_->bodies;
}
const SimulationSettings& Simulation::settings() const {
  return state_->settings;
}
std::span<const Vec3> Simulation::positions() const {
  return state_->dynamics.positions();
}
std::span<const Vec3> Simulation::velocities() const {
  return state_->dynamics.velocities();
}
const Detector& Simulation::detector() const {
  return state_->detector;
}
const StepMetrics& Simulation::metrics() const {
  return state_->metrics;
}
bool Simulation::at_rest() const {
  // Rounding of the product must not add a step.
  constexpr double rounding = 1e-9;
  return static_cast<double>(state_->slow_steps) * state_->settings.time_step >=
         state_->settings.rest.time * (1.0 - rounding);
}
std::span<const double> Simulation::point_masses() const {
  return state_->dynamics.point_masses();
}
std::span<const double> Simulation::masses() const {
  return state_->masses;
}

std::span<const Material> Simulation::contact_materials() const {
  return state_->contact_materials;
}

std::string Simulation::state_hash() const {
  return palpate::state_hash(positions(), velocities());
}

}  // namespace palpate
