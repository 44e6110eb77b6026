#include <algorithm>
#include <array>
#include <cmath>
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

}  // namespace

struct Simulation::State {
  State(Bodies b, std::vector<Material> m, std::vector<std::uint8_t> fixed, std::vector<std::uint8_t> o,
        const SimulationSettings& s, int n)
      : bodies(std::move(b)),
        settings(checked(s)),
        obstacles(flags_or_none(std::move(o), bodies.bodies().size(), "obstacles")),
        threads(n),
        dynamics(bodies, m, flags_or_none(std::move(fixed), bodies.points_rest().size(), "fixed_points"),
                 obstacles, threads),
        detector(bodies, settings.detection, obstacles, n),
        response(bodies, m, obstacles, settings.response, dynamics.point_masses(), dynamics.free_points()),
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
  void sum_contact_forces();

  Bodies bodies;
  SimulationSettings settings;
  std::vector<std::uint8_t> obstacles;
  parallel::Threads threads;
  fem::Dynamics dynamics;
  Detector detector;
  ContactResponse response;
  std::vector<fem::Coupling> couplings;
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
  dynamics.end_step();
}

void Simulation::State::sum_contact_forces() {
  std::fill(contact_forces.begin(), contact_forces.end(), Vec3{});
  for (const fem::Coupling& coupling : couplings) {
    const Vec3 force = fem::end_force(coupling, settings.time_step, dynamics.velocities());
    at(contact_forces, at(bodies.body_of_point(), coupling.points[0])) += force;
    at(contact_forces, at(bodies.body_of_point(), coupling.points[1])) -= force;
  }
}

Simulation::Simulation(Bodies bodies, std::vector<Material> materials, std::vector<std::uint8_t> fixed_points,
                       std::vector<std::uint8_t> obstacles, const SimulationSettings& settings, int threads)
    : state_(std::make_unique<State>(std::move(bodies), std::move(materials), std::move(fixed_points),
                                     std::move(obstacles), settings, threads)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const StepMetrics& Simulation::step() {
  State& s = *state_;
  Stopwatch watch;
  s.response.compute(s.threads, s.bodies, s.detector.contacts(), s.dynamics.positions(),
                     s.dynamics.velocities(), s.settings.time_step, s.couplings);
  s.metrics.forces_seconds = watch.lap();

  s.solve();
  s.metrics.solver_seconds = watch.lap();
  s.sum_contact_forces();

  s.detect();
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

std::string Simulation::state_hash() const {
  return palpate::state_hash(positions(), velocities());
}

}  // namespace palpate
