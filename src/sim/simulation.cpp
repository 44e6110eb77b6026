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
#include "mesh/unused_points.hpp"
#include "number_text.hpp"
#include "room.hpp"
#include "sim/model_check.hpp"
#include "sim/simulation_state.hpp"
#include "sim/state_hash.hpp"
#include "stopwatch.hpp"

namespace palpate {
namespace {

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
  check(s.solver.max_substeps > 0 && s.solver.max_substeps <= SolverSettings::most_substeps,
        "solver.max_substeps", s.solver.max_substeps, "1 to 64");
  check(s.rest.speed > 0.0, "rest.speed", s.rest.speed, "a finite number > 0");
  check(s.rest.time > 0.0, "rest.time", s.rest.time, "a finite number > 0");
  const double max_speed = s.limits.max_speed.value_or(1.0);
  check(max_speed > 0.0, "limits.max_speed", max_speed, "a finite number > 0");
  const double inverted_time = s.limits.inverted_time.value_or(1.0);
  check(inverted_time > 0.0, "limits.inverted_time", inverted_time, "a finite number > 0");
  return s;
}

/// Throws Error if BDF2 is combined with viscosity, which it does not support.
void check_integration(const SimulationSettings& s, bool viscous) {
  if (s.time_integration == TimeIntegration::implicit_euler || !viscous) return;
  throw Error("simulation settings", "time_integration", "bdf2 with viscous tissue", "implicit-euler");
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
      dynamics(bodies, materials, constrained_points(holds, bodies), obstacles, threads),
      loads(std::move(load_set), bodies, holds.obstacles, dynamics.ambient_bodies(), dynamics.free_points(),
            dynamics.point_masses()),
      grabs(static_cast<Index>(bodies.points_rest().size())),
      detector(bodies, without_absent(settings.detection, holds.absent), obstacles, n),
      contact_materials(fem::mean_materials(bodies, materials)),
      response(bodies, contact_materials, obstacles, settings.response, dynamics.point_masses(),
               dynamics.free_points()),
      swept(bodies),
      max_speed(speed_limit(bodies, settings)),
      contact_forces(bodies.bodies().size()),
      masses(bodies.bodies().size(), 0.0),
      squared_speeds(bodies.bodies().size(), 0.0),
      last_length(settings.time_step) {
  for (std::size_t p = 0; p < dynamics.point_masses().size(); ++p) {
    at(masses, bodies.body_of_point()[p]) += dynamics.point_masses()[p];
  }
  check_integration(settings, dynamics.elements().is_viscous());
  dynamics.keep_past(settings.time_integration == TimeIntegration::bdf2);
  activations.resize(materials.all.size());
  activate_fibres(0.0);
  dynamics.set_fixed_axes(bodies, materials, holds.fixed_axes);
  dynamics.set_positions(prescribed.start_positions(threads, bodies.points_rest()));
  ties = Ties(holds.ties, bodies, dynamics.point_masses(), dynamics.free_points(), response);
  step_forces.set({}, std::vector<Vec3>(holds.ties.size()));
  DetectorSteps::set_tied_points(detector, tied_points(holds.ties, bodies, response));
  response.use_edges(DetectorSteps::surfaces(detector));
  response.set_flush_faces(FlushFaces(bodies, bodies_at_rest(holds, bodies), dynamics.positions()));
}

void Simulation::State::start(const std::vector<Vec3>& velocities, const std::vector<Grab>& all_grabs) {
  for (const Grab& grab : all_grabs) {
    grabs.add(grab);
    check_used(bodies, grab.point, "grab", "point");
  }
  if (!velocities.empty()) dynamics.set_velocities(velocities);
  detect(dynamics.positions(), true);
  measure();
}

/// Computes energies and extremes at the end of a step.
void Simulation::State::measure() {
  metrics.kinetic_energy = dynamics.kinetic_energy();
  metrics.elastic_energy = dynamics.elastic_energy();
  metrics.inverted_tets = dynamics.inverted_elements();
  double fastest = 0.0;
  std::fill(squared_speeds.begin(), squared_speeds.end(), 0.0);
  for (std::size_t p = 0; p < dynamics.velocities().size(); ++p) {
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

double Simulation::State::last_change() const {
  double last = std::max(prescribed.end(), loads.end());
  for (const Material& material : materials.all) last = std::max(last, end_of(material.fibres.activation));
  return last;
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

const StepMetrics& Simulation::step() {
  State& s = *state_;
  const StepMetrics last = s.metrics;
  try {
    s.advance();
  } catch (const Error& error) {
    s.set_metrics(last);
    const std::string step = "step " + std::to_string(last.step + 1);
    const std::string where = error.where().empty() ? step : error.where() + ", " + step;
    throw Error(error.source(), where, error.found(), error.expected());
  }
  ++s.metrics.step;
  s.metrics.time = static_cast<double>(s.metrics.step) * s.settings.time_step;
  s.measure();
  // What did not converge is not known to rest. Fixed iterations need not converge.
  const bool known = s.metrics.solver_converged || s.settings.solver.fixed_iterations.has_value();
  const bool slow =
      known && s.metrics.fastest_body <= s.settings.rest.speed && s.metrics.time >= s.last_change();
  s.slow_steps = slow ? s.slow_steps + 1 : 0;
  return s.metrics;
}

void Simulation::change(const SimulationSettings& settings) {
  State& s = *state_;
  checked(settings);
  ContactResponse::check_settings(settings.response);
  check_integration(settings, s.dynamics.elements().is_viscous());
  if (settings.time_step != s.settings.time_step) {
    throw Error(
        "simulation settings", "time_step", number_text(settings.time_step),
        number_text(s.settings.time_step) + ", the current value: it cannot change during a simulation");
  }
  if (settings.detection != s.settings.detection) {
    Detector detector(s.bodies, without_absent(settings.detection, s.holds.absent), s.obstacles,
                      s.threads.count());
    detector.detect(s.dynamics.positions());
    DetectorSteps::table(detector).set_history(DetectorSteps::table(s.detector).history());
    s.detector = std::move(detector);
  }
  s.response.change(settings.response);
  s.response.use_edges(DetectorSteps::surfaces(s.detector));
  s.settings = settings;
  s.dynamics.keep_past(settings.time_integration == TimeIntegration::bdf2);
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
std::span<const std::uint8_t> Simulation::free_points() const {
  return state_->dynamics.free_points();
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
