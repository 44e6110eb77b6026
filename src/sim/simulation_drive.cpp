#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/detector_steps.hpp"
#include "geometry/vector.hpp"
#include "mesh/unused_points.hpp"
#include "sim/simulation_state.hpp"

// Functions that change a simulation between steps.
namespace palpate {
namespace {

/// Checks values for points: one for each, finite, and only for points where may(point) is true.
template <class May>
void check_values(const char* name, std::span<const Index> points, std::span<const Vec3> values,
                  std::size_t count, May&& may, const char* why, const char* expected) {
  if (points.size() != values.size()) {
    throw Error("simulation", name, std::to_string(values.size()) + " values",
                std::to_string(points.size()) + ", one for each point");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < 0 || static_cast<std::size_t>(points[i]) >= count)
      throw Error("simulation", "point", std::to_string(points[i]), "less than " + std::to_string(count));
    if (!is_finite(values[i]))
      throw Error("simulation", name, "a number that is not finite", "three finite numbers");
    if (!may(points[i]))
      throw Error("simulation", name, "point " + std::to_string(points[i]) + why, expected);
  }
}

/// Checks that a point, if it exists, is not of a body of some kind.
/// \param of_kind  per body
/// \param kind     its name
void check_body(const Bodies& bodies, std::span<const std::uint8_t> of_kind, const char* kind,
                const char* name, Index point, const char* expected) {
  if (point < 0 || point >= std::ssize(bodies.body_of_point())) return;
  const Index body = at(bodies.body_of_point(), point);
  if (at(of_kind, body) == 0) return;
  throw Error(
      "simulation", name,
      "point " + std::to_string(point) + " of the " + kind + " body '" + at(bodies.bodies(), body).name + "'",
      expected);
}

/// Checks that a point, if it exists, is in a tet of a body that is in the scene and deforms.
void check_deforms(const Bodies& bodies, const Holds& holds, const char* name, Index point,
                   const char* expected) {
  check_body(bodies, holds.absent, "removed", name, point, expected);
  check_body(bodies, holds.obstacles, "rigid", name, point, expected);
  if (point >= 0 && static_cast<std::size_t>(point) < bodies.points_rest().size())
    check_used(bodies, point, "simulation", name);
}

}  // namespace

void Simulation::set_motion(Index number, Motion motion) {
  state_->prescribed.replace(number, std::move(motion));
  state_->slow_steps = 0;
}

const Motion& Simulation::motion(Index number) const {
  const std::span<const Motion> motions = state_->prescribed.motions();
  if (number < 0 || static_cast<std::size_t>(number) >= motions.size()) {
    throw Error("simulation", "motion", std::to_string(number),
                "less than " + std::to_string(motions.size()));
  }
  return at(motions, number);
}

void Simulation::move_to(Index number, const Keyframe& pose) {
  set_motion(number, {motion(number).center, {pose}, Interpolation::linear});
}

void Simulation::set_force(Index point, const Vec3& force) {
  set_forces(std::array{point}, std::array{force});
}
void Simulation::set_forces(std::span<const Index> points, std::span<const Vec3> forces) {
  for (std::size_t i = 0; i < std::min(points.size(), forces.size()); ++i) {
    if (forces[i] == Vec3{}) continue;
    check_deforms(state_->bodies, state_->holds, "forces", points[i], "points of bodies that deform");
  }
  state_->loads.set_forces(points, forces);
}
void Simulation::set_pressure(std::span<const Index> triangles, double pressure) {
  state_->loads.set_pressure(state_->bodies, triangles, pressure);
}
void Simulation::set_pressure(std::span<const Index> triangles, std::span<const double> pressures) {
  state_->loads.set_pressure(state_->bodies, triangles, pressures);
}

void Simulation::set_positions(std::span<const Index> points, std::span<const Vec3> positions) {
  State& s = *state_;
  const auto is_prescribed = [&](Index p) { return std::ranges::binary_search(s.prescribed.points(), p); };
  check_values(
      "positions", points, positions, s.bodies.points_rest().size(),
      [&](Index p) { return !is_prescribed(p); }, ", which has a prescribed motion",
      "points that no motion moves");
  for (const Index p : points) {
    check_body(s.bodies, s.holds.obstacles, "rigid", "positions", p,
               "points of bodies that deform, or a motion that moves the whole body");
  }
  std::vector<Vec3> all(s.dynamics.positions().begin(), s.dynamics.positions().end());
  for (std::size_t i = 0; i < points.size(); ++i) at(all, points[i]) = positions[i];
  const StepMetrics before = s.metrics;
  DetectorSteps::hold(s.detector);
  try {
    s.detect(all, true);
  } catch (...) {
    s.set_metrics(before);
    DetectorSteps::swap_back(s.detector);
    throw;
  }
  DetectorSteps::release(s.detector);
  s.metrics.detection_seconds = before.detection_seconds;
  s.dynamics.set_positions(all);
  s.measure();
  s.slow_steps = 0;
}

void Simulation::set_velocities(std::span<const Index> points, std::span<const Vec3> velocities) {
  State& s = *state_;
  check_values(
      "velocities", points, velocities, s.bodies.points_rest().size(),
      [&](Index p) { return at(s.dynamics.free_points(), p) != 0; }, ", which does not move freely",
      "points that are neither fixed nor prescribed");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (fem::along(at(s.dynamics.held_axes(), points[i]), velocities[i]) == Vec3{}) continue;
    throw Error("simulation", "velocities",
                "point " + std::to_string(points[i]) + ", which moves along an axis that is fixed",
                "a velocity of zero along it");
  }
  s.dynamics.set_velocities(points, velocities);
  s.measure();
  s.slow_steps = 0;
}

Index Simulation::grab(const Grab& grab) {
  check_deforms(state_->bodies, state_->holds, "grab", grab.point, "a point of a body that deforms");
  return state_->grabs.add(grab);
}
void Simulation::move_grab(Index number, const Vec3& target) {
  state_->grabs.move(number, target);
}
void Simulation::release(Index number) {
  state_->grabs.release(number);
}
Vec3 Simulation::grab_force(Index number) const {
  return state_->grabs.held(number).force;
}
const Grab& Simulation::grab_of(Index number) const {
  return state_->grabs.held(number).grab;
}
std::vector<Index> Simulation::grabs() const {
  std::vector<Index> numbers;
  const std::vector<HeldGrab>& all = state_->grabs.all();
  for (Index g = 0; g < std::ssize(all); ++g) {
    if (at(all, g).grab.point >= 0) numbers.push_back(g);
  }
  return numbers;
}

}  // namespace palpate
