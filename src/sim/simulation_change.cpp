#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "contact/detector_steps.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_state.hpp"

// Changes of constraints, motions, ties and loads of a simulation.
namespace palpate {
namespace {

/// Copies values by element to the elements with the same tets; zero for tets without a value.
template <class T>
std::vector<T> for_elements(const std::vector<T>& values, std::span<const Index> tets_before,
                            std::span<const Index> tets_after, std::size_t tet_count) {
  if (values.empty()) return std::vector<T>(tets_after.size());
  std::vector<T> of_tet(tet_count);
  for (std::size_t e = 0; e < values.size(); ++e) at(of_tet, tets_before[e]) = values[e];
  std::vector<T> after;
  after.reserve(tets_after.size());
  for (const Index tet : tets_after) after.push_back(at(of_tet, tet));
  return after;
}

/// Copies values of bodies to the bodies that are present afterwards, in the same order within a body; zero
/// for bodies that were absent.
/// \param before, after  the body of each value
std::vector<fem::SymmetricMatrix3> for_bodies(const std::vector<fem::SymmetricMatrix3>& values,
                                              std::span<const Index> before, std::span<const Index> after,
                                              Index body_count) {
  std::vector<std::vector<fem::SymmetricMatrix3>> of_body(static_cast<std::size_t>(body_count));
  for (std::size_t k = 0; k < values.size(); ++k) at(of_body, before[k]).push_back(values[k]);
  std::vector<std::size_t> next(of_body.size());
  std::vector<fem::SymmetricMatrix3> there;
  there.reserve(after.size());
  for (const Index body : after) {
    const std::vector<fem::SymmetricMatrix3>& own = at(of_body, body);
    there.push_back(own.empty() ? fem::SymmetricMatrix3{} : own.at(at(next, body)++));
  }
  return there;
}

/// Forces of the ties after a change: unchanged for ties that existed before, zero for new ones.
std::vector<Vec3> forces_of_ties(const std::vector<HeldTie>& ties, const std::vector<HeldTie>& before,
                                 const std::vector<Vec3>& forces) {
  std::vector<Vec3> all;
  std::size_t next = 0;  // ties keep their order, and new ones come last
  const auto same = [](const HeldTie& a, const HeldTie& b) {
    return a.tie.point == b.tie.point && a.tie.tet == b.tie.tet && a.weights == b.weights;
  };
  for (const HeldTie& tie : ties) {
    while (next < before.size() && !same(before[next], tie)) ++next;
    all.push_back(next < before.size() ? forces[next++] : Vec3{});
  }
  return all;
}

}  // namespace

/// Sets velocities of fixed points to zero; those of prescribed points stay. An inserted body is placed at
/// the current pose of its motion.
void Simulation::State::copy_from(const State& from) {
  SavedState saved = from.saved_state();
  fem::DynamicsState& d = saved.dynamics;
  const std::size_t tets = bodies.tets().size();
  const std::span<const Index> before = from.dynamics.tet_of_element();
  const std::span<const Index> after = dynamics.tet_of_element();
  d.inversion_clocks = for_elements(d.inversion_clocks, before, after, tets);
  if (!dynamics.plastic_strains().empty())
    d.plastic_strains = for_elements(d.plastic_strains, before, after, tets);
  if (dynamics.plastic_strains().empty()) d.plastic_strains.clear();
  d.past_positions.clear();
  d.past_velocities.clear();
  d.viscous_stresses = for_bodies(d.viscous_stresses, from.dynamics.elements().body_of_viscous_stress(),
                                  dynamics.elements().body_of_viscous_stress(), bodies.body_count());
  const std::vector<Index> motions = motions_of_present(holds, bodies);
  const std::span<const Vec3> prescribed_positions = prescribed.positions(threads, saved.metrics.time);
  for (std::size_t k = 0; k < prescribed_positions.size(); ++k) {
    const Index p = prescribed.points()[k];
    if (at(from.holds.absent, at(bodies.body_of_point(), p)) != 0)
      at(d.positions, p) = prescribed_positions[k];
  }
  for (std::size_t p = 0; p < motions.size(); ++p) {
    if (dynamics.free_points()[p] != 0) continue;
    d.velocity_changes[p] = {};
    if (motions[p] < 0) d.velocities[p] = {};
  }
  activate_fibres(saved.metrics.time);
  dynamics.set_state(d);
  grabs.set_all(saved.grabs);
  contact_forces = saved.contact_forces;
  step_forces.set(saved.acting_contacts, forces_of_ties(holds.ties, from.holds.ties, saved.tie_forces));
  if (saved.records_reactions) dynamics.find_constrained_elements();
  records_reactions = saved.records_reactions;
  reactions = saved.reactions;
  const auto gone = [&](Index point, Index body) {
    return at(holds.absent, at(bodies.body_of_point(), point)) != 0 || at(holds.absent, body) != 0;
  };
  std::erase_if(saved.kept_contacts, [&](const KeptContact& c) { return gone(c.point, c.body); });
  std::erase_if(saved.edge_ends, [&](const EdgeEnd& e) { return gone(e.points.front(), e.body); });
  response.set_kept(saved.kept_contacts);
  response.set_edge_ends(saved.edge_ends);
  set_metrics(saved.metrics);
  last_length = saved.last_length;
  metrics.time = from.metrics.time;
  detect(dynamics.positions(), true);
  DetectorSteps::table(detector).set_history(saved.contacts);
  metrics.detection_seconds = from.metrics.detection_seconds;
  measure();
}

void Simulation::change(const ModelChange& change) {
  const State& s = *state_;
  const std::span<const Motion> motions = s.prescribed.motions();
  HeldModel held{.holds = s.holds, .motions = {motions.begin(), motions.end()}};
  apply_change(change, s.bodies, s.dynamics.positions(), held);
  LoadSet loads = s.loads.all();
  for (const BodyLoads& of_body : change.loads) replace_loads(of_body, s.bodies, loads);
  auto next =
      std::make_unique<State>(s.core, std::move(held), std::move(loads), s.settings, s.threads.count());
  next->changed = true;
  next->copy_from(s);
  state_ = std::move(next);
}

bool Simulation::is_present(Index body) const {
  const std::vector<std::uint8_t>& absent = state_->holds.absent;
  if (body < 0 || static_cast<std::size_t>(body) >= absent.size())
    throw Error("simulation", "body", std::to_string(body), "less than " + std::to_string(absent.size()));
  return at(absent, body) == 0;
}

bool Simulation::is_rigid(Index body) const {
  const std::vector<std::uint8_t>& rigid = state_->holds.obstacles;
  if (body < 0 || static_cast<std::size_t>(body) >= rigid.size())
    throw Error("simulation", "body", std::to_string(body), "less than " + std::to_string(rigid.size()));
  return at(rigid, body) != 0;
}

std::vector<Tie> Simulation::ties() const {
  std::vector<Tie> ties;
  for (const HeldTie& held : state_->holds.ties) ties.push_back(held.tie);
  return ties;
}

std::span<const Index> Simulation::motion_of_points() const {
  return state_->holds.motion_of_point;
}

Index Simulation::motion_count() const {
  return state_->prescribed.motion_count();
}

}  // namespace palpate
