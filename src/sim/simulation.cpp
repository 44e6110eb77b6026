#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "fem/dynamics.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "parallel/parallel.hpp"
#include "sim/response.hpp"
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
  check(s.solver.max_solves > 0, "solver.max_solves", s.solver.max_solves, "at least 1");
  check(s.rest.speed > 0.0, "rest.speed", s.rest.speed, "a finite number > 0");
  check(s.rest.time > 0.0, "rest.time", s.rest.time, "a finite number > 0");
  const double max_speed = s.limits.max_speed.value_or(1.0);
  check(max_speed > 0.0, "limits.max_speed", max_speed, "a finite number > 0");
  check(s.limits.inverted_steps > 0, "limits.inverted_steps", s.limits.inverted_steps, "at least 1");
  return s;
}

/// One flag for each of `count`, all 0 where none are given.
std::vector<std::uint8_t> flags_or_none(std::vector<std::uint8_t> flags, std::size_t count,
                                        const char* name) {
  if (flags.empty()) flags.assign(count, 0);
  if (flags.size() != count) {
    throw Error("simulation", name, std::to_string(flags.size()) + " flags", std::to_string(count));
  }
  return flags;
}

/// The speed that LimitSettings says, or the one that stands for none.
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

/// See Simulation::contact_materials(). A body without volume keeps its own.
std::vector<Material> mean_materials(const Bodies& bodies, const Materials& materials) {
  std::vector<Material> means(materials.all.begin(), materials.all.begin() + bodies.body_count());
  if (materials.of_tet.empty()) return means;
  for (Index body = 0; body < bodies.body_count(); ++body) {
    const double own = at(means, body).young_modulus;
    double change = 0.0;
    double volume = 0.0;
    const Range tets = at(bodies.bodies(), body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      const double share = fem::tet_volume_rest(bodies, tet);
      change += share * (materials.of(tet, body).young_modulus - own);
      volume += share;
    }
    if (change != 0.0) at(means, body).young_modulus += change / volume;
  }
  return means;
}

}  // namespace

struct Simulation::State {
  State(Bodies b, const Materials& m, std::vector<std::uint8_t> fixed, std::vector<std::uint8_t> o,
        const SimulationSettings& s, int n)
      : bodies(std::move(b)),
        settings(checked(s)),
        obstacles(flags_or_none(std::move(o), bodies.bodies().size(), "obstacles")),
        threads(n),
        dynamics(bodies, m, flags_or_none(std::move(fixed), bodies.points_rest().size(), "fixed_points"),
                 obstacles, threads),
        detector(bodies, settings.detection, obstacles, n),
        contact_materials(mean_materials(bodies, m)),
        response(bodies, contact_materials, obstacles, settings.response, dynamics.point_masses(),
                 dynamics.free_points()),
        max_speed(speed_limit(bodies, settings)),
        contact_forces(bodies.bodies().size()),
        masses(bodies.bodies().size(), 0.0),
        squared_speeds(bodies.bodies().size(), 0.0) {
    for (std::size_t p = 0; p < dynamics.point_masses().size(); ++p) {
      at(masses, bodies.body_of_point()[p]) += dynamics.point_masses()[p];
    }
    detect();
    measure();
  }

  void detect();
  void measure();
  void solve();
  void advance();
  void sum_contact_forces();

  Bodies bodies;
  SimulationSettings settings;
  std::vector<std::uint8_t> obstacles;
  parallel::Threads threads;
  fem::Dynamics dynamics;
  Detector detector;
  std::vector<Material> contact_materials;
  ContactResponse response;
  std::vector<fem::Coupling> couplings;
  double max_speed;
  std::vector<Vec3> contact_forces;
  std::vector<double> masses;
  std::vector<double> squared_speeds;  ///< per body: sum of m v^2
  StepMetrics metrics;
  int slow_steps = 0;  ///< steps in a row in which no body was faster than the rest speed
};

void Simulation::State::detect() {
  detector.detect(dynamics.positions());
  metrics.detection = detector.counts();
  metrics.detection_seconds = detector.times();
}

/// Energies and extremes at the end of a step.
void Simulation::State::measure() {
  metrics.kinetic_energy = dynamics.kinetic_energy();
  metrics.elastic_energy = dynamics.elastic_energy();
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
  const std::vector<double>& depth = detector.contacts().depth;
  metrics.deepest = depth.empty() ? 0.0 : *std::max_element(depth.begin(), depth.end());
}

/// Solves, and again with the friction that the solution leads to, until both agree.
void Simulation::State::solve() {
  dynamics.begin_step(settings.time_step, settings.gravity, {});
  metrics.solves = 0;
  metrics.solver_iterations = 0;
  metrics.solver_converged = true;
  do {
    const fem::SolveReport report =
        dynamics.solve(couplings, settings.solver.tolerance, settings.solver.max_iterations);
    ++metrics.solves;
    metrics.solver_iterations += report.iterations;
    metrics.solver_converged = metrics.solver_converged && report.converged;
  } while (metrics.solves < settings.solver.max_solves &&
           response.refine(threads, dynamics.end_velocities(), couplings));
  dynamics.check_limits(max_speed, settings.limits.inverted_steps);
}

void Simulation::State::sum_contact_forces() {
  std::fill(contact_forces.begin(), contact_forces.end(), Vec3{});
  for (const fem::Coupling& coupling : couplings) {
    const Vec3 force = fem::end_force(coupling, settings.time_step, dynamics.velocities());
    at(contact_forces, at(bodies.body_of_point(), coupling.points[0])) += force;
    at(contact_forces, at(bodies.body_of_point(), coupling.points[1])) -= force;
  }
}

Simulation::Simulation(Bodies bodies, Materials materials, std::vector<std::uint8_t> fixed_points,
                       std::vector<std::uint8_t> obstacles, const SimulationSettings& settings, int threads)
    : state_(std::make_unique<State>(std::move(bodies), materials, std::move(fixed_points),
                                     std::move(obstacles), settings, threads)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

/// The parts of a step that can fail, from forces to the contacts of the new positions; where they do, the
/// state is as it was.
void Simulation::State::advance() {
  Stopwatch watch;
  response.compute(threads, bodies, detector.contacts(), dynamics.positions(), dynamics.velocities(),
                   settings.time_step, couplings);
  metrics.forces_seconds = watch.lap();
  solve();
  dynamics.end_step();
  metrics.solver_seconds = watch.lap();
  try {
    detect();
  } catch (...) {
    dynamics.undo_step();
    detect();
    throw;
  }
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
  s.sum_contact_forces();
  ++s.metrics.step;
  s.metrics.time = static_cast<double>(s.metrics.step) * s.settings.time_step;
  s.measure();
  s.slow_steps = s.metrics.fastest_body <= s.settings.rest.speed ? s.slow_steps + 1 : 0;
  return s.metrics;
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
  // Rounding of the product must not ask for one step more.
  constexpr double rounding = 1e-9;
  return static_cast<double>(state_->slow_steps) * state_->settings.time_step >=
         state_->settings.rest.time * (1.0 - rounding);
}
std::span<const Vec3> Simulation::contact_forces() const {
  return state_->contact_forces;
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
