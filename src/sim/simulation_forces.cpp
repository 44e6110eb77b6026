#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "fem/tissue.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_state.hpp"
#include "sim/tractions.hpp"
#include "sim/wrench.hpp"

// Forces and stress of a simulation.
namespace palpate {
namespace {

void check_index(const char* what, Index found, Index count) {
  if (found < 0 || found >= count) {
    const std::string expected =
        count > 0 ? "0 to " + std::to_string(count - 1) : "no index, since there is no " + std::string(what);
    throw Error("simulation", what, std::to_string(found), expected);
  }
}

}  // namespace

/// Records forces and reactions; call between the last solve and the end of the step.
void Simulation::State::collect_forces() {
  step_forces.take(
      threads, couplings,
      {.first_tie = first_tie, .first_contact = first_contact, .first_speculative = first_speculative},
      response, step_length(), dynamics.mean_velocities());
  step_forces.sum_over_bodies(bodies, contact_forces);
  if (!records_reactions) {
    reactions.clear();
    return;
  }
  reactions.resize(bodies.points_rest().size());
  dynamics.holding_forces(settings.gravity, step_loads.all, reactions);
  for (std::size_t p = 0; p < reactions.size(); ++p)
    if (at(holds.absent, bodies.body_of_point()[p]) != 0) reactions[p] = {};
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = couplings[c].points[k];
      if (point < 0 || at(dynamics.held_axes(), point) == 0) continue;
      at(reactions, point) -=
          fem::along(at(dynamics.held_axes(), point), couplings[c].coefficients[k] * step_forces.all()[c]);
    }
  }
}

void Simulation::record_reactions(bool on) {
  State& s = *state_;
  if (on && !s.records_reactions) s.dynamics.find_constrained_elements();
  s.records_reactions = on;
}

std::span<const Vec3> Simulation::contact_forces() const {
  return state_->contact_forces;
}

ContactForces Simulation::acting_contacts() const {
  return contact_forces_of(state_->step_forces.contacts(), state_->bodies);
}

Vec3 Simulation::center_of_mass(Index body) const {
  const State& s = *state_;
  check_index("body", body, s.bodies.body_count());
  return palpate::center_of_mass(at(s.bodies.bodies(), body), s.dynamics.point_masses(), positions());
}

Wrench Simulation::contact_wrench(Index body) const {
  return contact_wrench(body, center_of_mass(body));
}
Wrench Simulation::contact_wrench(Index body, const Vec3& about) const {
  check_index("body", body, bodies().body_count());
  check_about(about);
  return wrench_on(state_->step_forces.contacts(), bodies(), positions(), body, about);
}

std::vector<PairWrench> Simulation::pair_wrenches() const {
  std::vector<Vec3> centers;
  centers.reserve(bodies().bodies().size());
  for (Index b = 0; b < bodies().body_count(); ++b) centers.push_back(center_of_mass(b));
  return wrenches_of_pairs(state_->step_forces.contacts(), bodies(), positions(), centers);
}
std::vector<PairWrench> Simulation::pair_wrenches(const Vec3& about) const {
  check_about(about);
  const std::vector<Vec3> centers(bodies().bodies().size(), about);
  return wrenches_of_pairs(state_->step_forces.contacts(), bodies(), positions(), centers);
}

SurfaceTractions Simulation::tractions() const {
  return tractions_of(state_->step_forces.contacts(), bodies(), positions());
}

std::span<const Vec3> Simulation::tie_forces() const {
  return state_->step_forces.ties();
}

Wrench Simulation::tie_wrench(Index body, const Vec3& about) const {
  check_index("body", body, bodies().body_count());
  check_about(about);
  Wrench sum{.force = {}, .torque = {}, .about = about};
  const std::vector<HeldTie>& ties = state_->holds.ties;
  const Range& points = at(bodies().bodies(), body).points;
  const auto has = [&](Index p) { return points.begin <= p && p < points.end; };
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const Vec3& force = tie_forces()[t];
    const Tet& tet = at(bodies().tets(), ties[t].tie.tet);
    if (has(ties[t].tie.point)) add_force(force, at(positions(), ties[t].tie.point), sum);
    if (!has(tet[0])) continue;
    Vec3 place;
    for (std::size_t k = 0; k < 4; ++k) place += ties[t].weights[k] * at(positions(), tet[k]);
    add_force(-force, place, sum);
  }
  return sum;
}

Wrench Simulation::grab_wrench(Index body, const Vec3& about) const {
  check_index("body", body, bodies().body_count());
  check_about(about);
  Wrench sum{.force = {}, .torque = {}, .about = about};
  for (const HeldGrab& held : state_->grabs.all()) {
    if (held.grab.point < 0 || at(bodies().body_of_point(), held.grab.point) != body) continue;
    add_force(held.force, at(positions(), held.grab.point), sum);
  }
  return sum;
}

std::span<const Vec3> Simulation::reactions() const {
  if (state_->reactions.empty() && !state_->bodies.points_rest().empty()) {
    throw Error("simulation", "reactions", "a step that did not record them",
                "a step after record_reactions(true)");
  }
  return state_->reactions;
}

Wrench Simulation::reaction_of_body(Index body, const Vec3& about) const {
  check_index("body", body, bodies().body_count());
  check_about(about);
  return wrench_of_points(reactions(), positions(), at(bodies().bodies(), body).points, about,
                          [](Index) { return true; });
}

Wrench Simulation::reaction_of_motion(Index motion, const Vec3& about) const {
  const PrescribedMotions& prescribed = state_->prescribed;
  check_index("motion", motion, prescribed.motion_count());
  check_about(about);
  const std::span<const Vec3> all = reactions();
  Wrench sum{.force = {}, .torque = {}, .about = about};
  for (std::size_t i = 0; i < prescribed.points().size(); ++i) {
    if (prescribed.motion_of_points()[i] != motion) continue;
    const Index p = prescribed.points()[i];
    add_force(at(all, p), at(positions(), p), sum);
  }
  return sum;
}

TissueState Simulation::tissue(TissueState memory) const {
  const State& s = *state_;
  return fem::tissue_of_tets(s.threads, s.bodies, s.dynamics.elements(), positions(), std::move(memory));
}

TissueState Simulation::tissue_at_points() const {
  const State& s = *state_;
  const TissueState tets = fem::strain_of_tets(s.threads, s.bodies, s.dynamics.elements(), positions());
  return fem::tissue_of_points(s.threads, s.bodies, s.dynamics.elements(), s.materials, tets);
}
TissueState Simulation::tissue_at_points(const TissueState& of_tets, TissueState memory) const {
  const State& s = *state_;
  if (of_tets.size() != s.bodies.tets().size()) {
    throw Error("simulation", "tissue", std::to_string(of_tets.size()) + " rows",
                std::to_string(s.bodies.tets().size()) + ", one for each tet");
  }
  return fem::tissue_of_points(s.threads, s.bodies, s.dynamics.elements(), s.materials, of_tets,
                               std::move(memory));
}

}  // namespace palpate
