#include "sim/response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "room.hpp"

namespace palpate {
namespace {

void check(bool right, const char* key, double found, const char* expected) {
  if (!right || !std::isfinite(found)) throw Error("contact settings", key, number_text(found), expected);
}

Vec3 across(const Vec3& a, const Vec3& r) {
  return a - dot(a, r) * r;
}

Vec3 bounded(const Vec3& a, double most) {
  return length(a) > most ? (most / length(a)) * a : a;
}

/// Of a point and the place of a tet with these weights, without a force yet.
fem::Coupling coupling_of(Index point, const Tet& tet, const std::array<double, 4>& w) {
  fem::Coupling coupling;
  coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
  coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
  return coupling;
}

constexpr std::size_t grain = 256;
/// Share of the damping of chatter that stays from step to step: it fades within a hundred steps.
constexpr double chatter_damping_kept = 0.99;
/// Bound of it: so many times the stiffness times the time step.
constexpr double most_chatter_damping = 20.0;
/// A contact stiff against h is damped as if critical damping were so many times k h; see the class.
constexpr double stiff_damping = 10.0;
/// Forces of contacts that are met within the step, by those that act: root mean squares below which they
/// are left to the next step.
constexpr double speculative_tolerance = 0.05;

}  // namespace

ContactResponse::ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                                 std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                                 std::span<const double> masses, std::span<const std::uint8_t> moves)
    : settings_(settings),
      body_compliance_(bodies.bodies().size(), 0.0),
      sides_(bodies),
      masses_(masses),
      moves_(moves) {
  check_settings(settings);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    if (at(obstacles, b) != 0) continue;
    const double h = mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean;
    at(body_compliance_, b) = 1.0 / (10.0 * at(materials, b).young_modulus * h);
  }
}

void ContactResponse::check_settings(const ResponseSettings& settings) {
  if (settings.stiffness)
    check(*settings.stiffness > 0.0, "stiffness", *settings.stiffness, "a finite number > 0");
  check(settings.damping >= 0.0, "damping", settings.damping, "a finite number >= 0");
  check(settings.friction >= 0.0, "friction", settings.friction, "a finite number >= 0");
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

double ContactResponse::reduced_mass(Index point, const Tet& tet,
                                     const std::array<double, 4>& weights) const {
  double inverse = at(moves_, point) != 0 ? 1.0 / at(masses_, point) : 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (at(moves_, tet[i]) != 0) inverse += weights[i] * weights[i] / at(masses_, tet[i]);
  }
  return inverse > 0.0 ? 1.0 / inverse : 0.0;
}

/// A contact that comes back, or whose point turns round, chatters: the force was not the one that the last
/// step's model foresaw. Damping of that error per speed holds it (see the class).
void ContactResponse::update_chatter_damping(RememberedContact& contact, const Vec3& force,
                                             const Vec3& velocity, double most) const {
  contact.chatter_damping *= chatter_damping_kept;
  const bool turns = contact.lost > 0 || dot(velocity, contact.velocity) < 0.0;
  const double speed = length(velocity);
  if (!turns || speed == 0.0) return;
  const Vec3 predicted =
      contact.force - (time_step_ * contact.stiffness * dot(contact.direction, velocity)) * contact.direction;
  contact.chatter_damping =
      std::min(std::max(contact.chatter_damping, length(force - predicted) / speed), most);
}

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities, double time_step, double fall,
                              std::vector<fem::Coupling>& couplings) {
  memory_.update(contacts);
  kept_.begin();
  sides_.begin(threads, bodies, positions, contacts.size());
  time_step_ = time_step;
  const std::size_t first = couplings.size();
  make_room(couplings, first + contacts.size());
  couplings.resize(first + contacts.size());
  resize_with_room(laws_, contacts.size());
  // What add_speculative() will ask for, so that a steady run asks in its first steps.
  make_room(unknown_, contacts.size());
  make_room(speculative_, contacts.size() / 8);
  make_room(added_, contacts.size() / 8);
  for_each_searching(threads, contacts.size(), [&](std::size_t c, ExitSearch& search) {
    compute_one(bodies, contacts, c, positions, velocities, search, couplings[first + c]);
  });
  kept_.make_room(contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    kept_.add(kept_contact(bodies, contacts.point[c], contacts.body[c], contacts.tet[c], contacts.weights[c],
                           contacts.depth[c], contacts.direction[c], laws_[c].stiffness, positions));
  }
  append_near(threads, bodies, contacts, positions, velocities, fall, couplings);
}

void ContactResponse::append_near(const parallel::Threads& threads, const Bodies& bodies,
                                  const Contacts& contacts, std::span<const Vec3> positions,
                                  std::span<const Vec3> velocities, double fall,
                                  std::vector<fem::Coupling>& couplings) {
  const auto near = kept_.near(threads, bodies, contacts, positions, velocities, time_step_, fall);
  resize_with_room(speculative_, near.size());
  parallel::for_each(threads, near.size(), grain, [&](std::size_t i) {
    const NearContact& contact = near[i];
    const KeptContact& kept = contact.kept;
    speculative_[i] = speculative(coupling_of(kept.point, at(bodies.tets(), kept.tet), contact.weights),
                                  -contact.gap, contact.direction, velocities, kept);
  });
  append_speculative(couplings);
}

/// f(i, search) for each i < size, with a search that is no other thread's.
template <class F>
void ContactResponse::for_each_searching(const parallel::Threads& threads, std::size_t size, const F& f) {
  const std::size_t chunks = parallel::chunk_count(size, grain);
  if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
  parallel::for_chunks(threads, size, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    for (std::size_t i = begin; i < end; ++i) f(i, searches_[chunk]);
  });
}

void ContactResponse::compute_one(const Bodies& bodies, const Contacts& contacts, std::size_t c,
                                  std::span<const Vec3> positions, std::span<const Vec3> velocities,
                                  ExitSearch& search, fem::Coupling& coupling) {
  const Index point = contacts.point[c];
  const Tet& tet = at(bodies.tets(), contacts.tet[c]);
  const std::array<double, 4>& w = contacts.weights[c];
  const Vec3& r = contacts.direction[c];
  const double full = stiffness(at(bodies.body_of_point(), point), contacts.body[c]);
  RememberedContact& remembered = memory_.of_contact(c);
  const double k = sides_.share(bodies, positions, contacts, c, search, remembered.side) * full;
  const double critical = 2.0 * std::sqrt(k * reduced_mass(point, tet, w));
  const double damping = settings_.damping * std::max(critical, stiff_damping * k * time_step_);

  coupling = coupling_of(point, tet, w);
  const Vec3 velocity = fem::relative(coupling, velocities);
  const Vec3 force = k * contacts.depth[c] * r;
  if (remembered.seen > 1) remembered.slip += time_step_ * velocity;
  if (remembered.seen > 1 || remembered.lost > 0)
    update_chatter_damping(remembered, force, velocity, most_chatter_damping * time_step_ * full);
  remembered.slip = bounded(across(remembered.slip, r), settings_.friction * contacts.depth[c]);
  laws_[c] = {.stiffness = k,
              .damping = damping + remembered.chatter_damping,
              .depth = contacts.depth[c],
              .slip = remembered.slip,
              .direction = r};
  remembered.force = force;
  remembered.direction = r;
  remembered.velocity = velocity;
  remembered.stiffness = k;
  remembered.lost = 0;
}

ContactResponse::Speculative ContactResponse::met(const Bodies& bodies, const Contacts& contacts,
                                                  std::size_t c, std::span<const Vec3> positions_end,
                                                  std::span<const Vec3> velocities_end,
                                                  ExitSearch& search) const {
  const Index point = contacts.point[c];
  const Index body = contacts.body[c];
  const Vec3& r = contacts.direction[c];
  const double k = sides_.share(bodies, positions_end, contacts, c, search) *
                   stiffness(at(bodies.body_of_point(), point), body);
  const auto& weights = contacts.weights[c];
  const fem::Coupling coupling = coupling_of(point, at(bodies.tets(), contacts.tet[c]), weights);
  // Where it was before the step, along the straight way that it came: outside.
  const double depth =
      std::min(contacts.depth[c] + time_step_ * dot(fem::relative(coupling, velocities_end), r), 0.0);
  return speculative(
      coupling, depth, r, velocities_end,
      kept_contact(bodies, point, body, contacts.tet[c], weights, contacts.depth[c], r, k, positions_end));
}

/// Without damping, and nothing remembered.
ContactResponse::Speculative ContactResponse::speculative(const fem::Coupling& coupling, double depth,
                                                          const Vec3& direction,
                                                          std::span<const Vec3> velocities,
                                                          const KeptContact& kept) const {
  const Vec3 velocity = fem::relative(coupling, velocities);
  const fem::ContactLaw law{
      .stiffness = kept.stiffness, .damping = 0.0, .depth = depth, .slip = {}, .direction = direction};
  return {.law = law,
          .coupling = coupling,
          .remembered = {.point = kept.point,
                         .body = kept.body,
                         .seen = 1,
                         .speculative = true,
                         .slip = {},
                         .force = (kept.stiffness * depth) * direction,
                         .direction = direction,
                         .velocity = velocity,
                         .stiffness = kept.stiffness,
                         .chatter_damping = 0.0,
                         .side = {}},
          .kept = kept,
          .force = fem::contact_force(law, {.coefficient = 0.0, .time_step = time_step_}, velocity).normal};
}

double ContactResponse::add_speculative(const parallel::Threads& threads, const Bodies& bodies,
                                        const Contacts& contacts, std::span<const Vec3> positions_end,
                                        std::span<const Vec3> velocities_end, double acting,
                                        std::vector<fem::Coupling>& couplings) {
  memory_.list_unknown(contacts, unknown_);
  resize_with_room(speculative_, unknown_.size());
  for_each_searching(threads, unknown_.size(), [&](std::size_t i, ExitSearch& search) {
    speculative_[i] = met(bodies, contacts, unknown_[i], positions_end, velocities_end, search);
  });
  std::erase_if(speculative_, [](const Speculative& contact) { return contact.force == 0.0; });
  const double met_with = parallel::sum(threads, speculative_.size(), partial_, [&](std::size_t i) {
    return speculative_[i].force * speculative_[i].force;
  });
  if (met_with <= speculative_tolerance * speculative_tolerance * acting * acting) return 0.0;
  append_speculative(couplings);
  return acting > 0.0 ? std::sqrt(met_with) / acting : std::numeric_limits<double>::infinity();
}

void ContactResponse::append_speculative(std::vector<fem::Coupling>& couplings) {
  make_room(laws_, laws_.size() + speculative_.size());
  make_room(couplings, couplings.size() + speculative_.size());
  make_room(added_, speculative_.size());
  kept_.make_room(speculative_.size());
  added_.clear();
  for (const Speculative& contact : speculative_) {
    kept_.add(contact.kept);
    laws_.push_back(contact.law);
    couplings.push_back(contact.coupling);
    added_.push_back(contact.remembered);
  }
  memory_.add(added_);
}

}  // namespace palpate
