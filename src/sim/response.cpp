#include "sim/response.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "room.hpp"

namespace palpate {
namespace {

void check_setting(bool right, const char* key, double found, const char* expected) {
  if (!right || !std::isfinite(found)) throw Error("contact settings", key, number_text(found), expected);
}

Vec3 bounded(const Vec3& a, double most) {
  return length(a) > most ? (most / length(a)) * a : a;
}

/// Factor of the chatter damping in each step: it fades within a few hundred steps.
constexpr double chatter_damping_kept = 0.99;
/// Upper bound of the chatter damping, relative to stiffness times time step.
constexpr double most_chatter_damping = 20.0;
/// Lower bound of the critical damping, relative to k h, for contacts that are stiff for the time step h; see
/// the class.
constexpr double stiff_damping = 10.0;

/// Depth, in mean edges of the penetrated body, from which a contact that was not there before acts softly,
/// with all others of the two bodies that were not there.
constexpr double starts_deep = 0.4;
/// Its first stiffness, times the square of the time step and relative to the reduced mass.
constexpr double soft_stiffness = 2.0;

/// The modulus from which the stiffness of contacts is derived, Pa: Young's modulus, and more where tissue is
/// nearly incompressible. Confined on all sides, it resists by the modulus of uniaxial strain; the contacts
/// around it must not yield more, relative to that, than with a Poisson's ratio of 0.4.
double contact_modulus(const Material& material) {
  const auto confined = [](double nu) { return (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)); };
  constexpr double usual = 0.4;
  return material.young_modulus * std::max(1.0, confined(material.poisson_ratio) / confined(usual));
}

/// Whether a contact acts for the first time.
bool begins(const ContactStates& states, std::size_t c) {
  return states.seen[c] == 1 && states.lost[c] == 0;
}

}  // namespace

fem::Coupling coupling_of(Index point, const Tet& tet, const std::array<double, 4>& w) {
  fem::Coupling coupling;
  coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
  coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
  return coupling;
}

ContactResponse::ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                                 std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                                 std::span<const double> masses, std::span<const std::uint8_t> moves)
    : settings_(settings),
      body_compliance_(bodies.bodies().size(), 0.0),
      rims_(bodies),
      masses_(masses),
      moves_(moves) {
  check_settings(settings);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    if (at(obstacles, b) != 0) continue;
    const double h = mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean;
    at(body_compliance_, b) = 1.0 / (10.0 * contact_modulus(at(materials, b)) * h);
  }
}

void ContactResponse::check_settings(const ResponseSettings& settings) {
  if (settings.stiffness)
    check_setting(*settings.stiffness > 0.0, "stiffness", *settings.stiffness, "a finite number > 0");
  check_setting(settings.damping >= 0.0, "damping", settings.damping, "a finite number >= 0");
  check_setting(settings.friction >= 0.0, "friction", settings.friction, "a finite number >= 0");
}

double ContactResponse::stiffness(Index body_a, Index body_b) const {
  return settings_.stiffness.value_or(1.0 / (at(body_compliance_, body_a) + at(body_compliance_, body_b)));
}

ContactOutcome ContactResponse::outcome(std::size_t contact, const Vec3& velocity) const {
  const fem::ContactLaw& law = laws_[contact];
  const fem::ContactForce force =
      fem::contact_force(law, {.coefficient = settings_.friction, .time_step = time_step_}, velocity);
  const bool slides = length(force.pull) > settings_.friction * force.normal;
  const ContactStatus status = force.normal == 0.0 ? ContactStatus::open
                               : slides            ? ContactStatus::slide
                                                   : ContactStatus::stick;
  return {law.depth, law.direction, status};
}

double ContactResponse::reduced_mass(const fem::Coupling& coupling) const {
  double inverse = 0.0;
  for (std::size_t i = 0; i < coupling.points.size(); ++i) {
    const Index point = coupling.points[i];
    const double weight = coupling.coefficients[i];
    if (point >= 0 && at(moves_, point) != 0) inverse += weight * weight / at(masses_, point);
  }
  return inverse > 0.0 ? 1.0 / inverse : 0.0;
}

double ContactResponse::damping(const fem::Coupling& coupling, double stiffness) const {
  const double critical = 2.0 * std::sqrt(stiffness * reduced_mass(coupling));
  return settings_.damping * std::max(critical, stiff_damping * stiffness * time_step_);
}

Vec3 ContactResponse::bounded_slip(const Vec3& slip, const fem::ContactLaw& law) const {
  return bounded(across(slip, law.direction), settings_.friction * law.depth);
}

/// A contact chatters if it returns or its relative velocity reverses: its force was not the predicted one.
/// The damping is that error divided by the speed (see the class).
double ContactResponse::chatter_damping(const Acted& last, const Vec3& force, const Vec3& velocity,
                                        double full) const {
  const double damping = chatter_damping_kept * last.damping;
  const bool reverses = last.comes_back || dot(velocity, last.velocity) < 0.0;
  const double speed = length(velocity);
  if (!reverses || speed == 0.0) return damping;
  const Vec3& r = last.direction;
  const Vec3 predicted = last.force - (since_ * last.stiffness * dot(r, velocity)) * r;
  return std::min(std::max(damping, length(force - predicted) / speed),
                  most_chatter_damping * time_step_ * full);
}

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies, ContactTable& table,
                              std::span<const Vec3> positions, std::span<const Vec3> velocities,
                              const StepTimes& times, double fall, std::vector<fem::Coupling>& couplings) {
  const std::size_t contacts = table.size();
  table.begin_step(threads);
  kept_.begin();
  rims_.begin(threads, bodies, positions, contacts);
  time_step_ = times.ahead;
  since_ = times.since;
  left_out_.clear();
  const std::size_t first = couplings.size();
  make_room(couplings, first + contacts);
  couplings.resize(first + contacts);
  resize_with_room(laws_, contacts);
  resize_with_room(scales_, contacts);
  assign_with_room(of_edge_, contacts, std::uint8_t{0});
  // Reserves room for the contacts of add_speculative(), so that only the first steps allocate.
  make_room(idle_, contacts);
  make_room(speculative_, contacts / 8);
  list_deep_pairs(bodies, table);
  for_each_searching(threads, contacts, [&](std::size_t c, ExitSearch& search) {
    compute_one(bodies, table, c, positions, velocities, search, couplings[first + c]);
  });
  const Contacts& list = table.contacts();
  const auto kept = kept_.add(contacts);
  parallel::for_each(threads, contacts, grain, [&](std::size_t c) {
    kept[c] = kept_contact(bodies, list.point[c], list.body[c], list.tet[c], list.weights[c], list.depth[c],
                           list.direction[c], laws_[c].stiffness, positions);
  });
  const auto frame = [&] {
    return EdgeResponse::Frame{*this,      surfaces_, rims_,      threads, bodies,  table, positions,
                               velocities, since_,    time_step_, fall,    scales_, flush_};
  };
  if (surfaces_.normals != nullptr) append_edges(edges_.begin(frame()), couplings);
  present_ = laws_.size();
  append_near(threads, bodies, table, positions, velocities, fall, couplings);
  if (surfaces_.normals != nullptr) append_edges(edges_.near(frame()), couplings);
}

void ContactResponse::append_edges(std::span<const EdgeResponse::Row> rows,
                                   std::vector<fem::Coupling>& couplings) {
  make_room(laws_, laws_.size() + rows.size());
  make_room(of_edge_, of_edge_.size() + rows.size());
  make_room(couplings, couplings.size() + rows.size());
  for (const auto& [end, depth, force] : rows) {
    laws_.push_back(end.law);
    laws_.back().depth = depth;
    of_edge_.push_back(end.of_edge ? 1 : 0);
    couplings.push_back(end.coupling());
  }
}

void ContactResponse::list_deep_pairs(const Bodies& bodies, const ContactTable& table) {
  const Contacts& contacts = table.contacts();
  deep_pairs_.clear();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (!begins(table.states(), c)) continue;
    const double edge = rims_.reach(contacts.body[c]) / reach_of_an_edge;
    if (contacts.depth[c] > starts_deep * edge)
      deep_pairs_.push_back(pair_of(at(bodies.body_of_point(), contacts.point[c]), contacts.body[c]));
  }
  std::ranges::sort(deep_pairs_);
  deep_pairs_.erase(std::ranges::unique(deep_pairs_).begin(), deep_pairs_.end());
}

double ContactResponse::stiffness_now(ContactStates& states, std::size_t c, double usual,
                                      const fem::Coupling& coupling, const PairOfBodies& pair) const {
  std::uint8_t& steps = states.soft[c];
  if (steps == 0 && !(begins(states, c) && std::ranges::binary_search(deep_pairs_, pair))) return usual;
  const double of_mass = soft_stiffness * reduced_mass(coupling) / (time_step_ * time_step_);
  const double soft = std::ldexp(of_mass, steps);
  if (!(soft < usual)) {
    steps = 0;
    return usual;
  }
  ++steps;
  return soft;
}

void ContactResponse::compute_one(const Bodies& bodies, ContactTable& table, std::size_t c,
                                  std::span<const Vec3> positions, std::span<const Vec3> velocities,
                                  ExitSearch& search, fem::Coupling& coupling) {
  const Contacts& contacts = table.contacts();
  ContactStates& states = table.states();
  const Index point = contacts.point[c];
  const Tet& tet = at(bodies.tets(), contacts.tet[c]);
  const std::array<double, 4>& w = contacts.weights[c];
  const Vec3& r = contacts.direction[c];
  const PairOfBodies pair = pair_of(at(bodies.body_of_point(), point), contacts.body[c]);
  const double full = stiffness(pair.first, pair.second);
  scales_[c] = rims_.scale(bodies, positions, contacts, c, search, table.rims());
  coupling = coupling_of(point, tet, w);
  const double k = stiffness_now(states, c, scales_[c] * full, coupling, pair);
  const Vec3 velocity = fem::relative(coupling, velocities);
  const Vec3 force = k * contacts.depth[c] * r;
  const bool acted_before = states.seen[c] > 1;
  Vec3 slip = states.slip[c];
  if (acted_before) slip += since_ * velocity;
  if (acted_before || states.lost[c] > 0) {
    states.chatter_damping[c] = chatter_damping({.force = states.force[c],
                                                 .direction = states.direction[c],
                                                 .velocity = states.velocity[c],
                                                 .stiffness = states.stiffness[c],
                                                 .damping = states.chatter_damping[c],
                                                 .comes_back = states.lost[c] > 0},
                                                force, velocity, full);
  }
  fem::ContactLaw& law = laws_[c];
  law = {.stiffness = k,
         .damping = damping(coupling, k) + states.chatter_damping[c],
         .depth = contacts.depth[c],
         .slip = {},
         .direction = r};
  law.slip = bounded_slip(slip, law);
  states.slip[c] = law.slip;
  states.force[c] = force;
  states.direction[c] = r;
  states.velocity[c] = velocity;
  states.stiffness[c] = k;
  states.lost[c] = 0;
}

void ContactResponse::move_back(const parallel::Threads& threads, std::span<const Vec3> places,
                                std::span<const Vec3> positions, std::span<const fem::Coupling> couplings) {
  parallel::for_each(threads, laws_.size(), grain, [&](std::size_t c) {
    const Vec3 motion = fem::relative(couplings[c], places) - fem::relative(couplings[c], positions);
    laws_[c].depth += dot(motion, laws_[c].direction);
    if (laws_[c].depth < 0.0) laws_[c].damping = 0.0;
  });
}

void ContactResponse::leave_out(const parallel::Threads& threads, std::span<const Vec3> excess,
                                std::span<const fem::Coupling> couplings) {
  make_room(left_out_, laws_.size());
  left_out_.resize(laws_.size());
  parallel::for_each(threads, laws_.size(), grain, [&](std::size_t c) {
    fem::ContactLaw& law = laws_[c];
    if (law.stiffness == 0.0) return;
    const Vec3 of_excess = (law.resistance(time_step_) / law.stiffness) *
                           across(fem::relative(couplings[c], excess), law.direction);
    law.slip += left_out_[c] - of_excess;
    left_out_[c] = of_excess;
  });
}

void ContactResponse::add_stops(std::span<const StopOfPassing> stops, std::vector<fem::Coupling>& couplings) {
  make_room(laws_, laws_.size() + stops.size());
  make_room(of_edge_, of_edge_.size() + stops.size());
  make_room(couplings, couplings.size() + stops.size());
  for (const StopOfPassing& stop : stops) {
    laws_.push_back(stop.law);
    of_edge_.push_back(stop.of_edge ? 1 : 0);
    couplings.push_back(stop.coupling);
  }
}

}  // namespace palpate
