#include "sim/response.hpp"

#include <algorithm>
#include <cmath>
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

fem::SymmetricMatrix3 outer_product(double s, const Vec3& r) {
  return {s * r.x * r.x, s * r.y * r.y, s * r.z * r.z, s * r.x * r.y, s * r.x * r.z, s * r.y * r.z};
}

Vec3 across(const Vec3& a, const Vec3& r) {
  return a - dot(a, r) * r;
}

Vec3 bounded(const Vec3& a, double most) {
  return length(a) > most ? (most / length(a)) * a : a;
}

/// m += s (I - r r^T)
void add_across(double s, const Vec3& r, fem::SymmetricMatrix3& m) {
  m.xx += s * (1.0 - r.x * r.x);
  m.yy += s * (1.0 - r.y * r.y);
  m.zz += s * (1.0 - r.z * r.z);
  m.xy -= s * r.x * r.y;
  m.xz -= s * r.x * r.z;
  m.yz -= s * r.y * r.z;
}

/// Of a point and the place of a tet with these weights, without a force yet.
fem::Coupling coupling_of(Index point, const Tet& tet, const std::array<double, 4>& w) {
  fem::Coupling coupling;
  coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
  coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
  return coupling;
}

constexpr std::size_t grain = 256;
/// Share of the calming that stays from step to step: it fades within a hundred steps.
constexpr double calming_kept = 0.99;
/// Bound of the calming: so many times the stiffness times the time step.
constexpr double most_calming = 20.0;
/// A contact stiff against h is damped as if critical damping were so many times k h; see the class.
constexpr double stiff_damping = 10.0;
/// Root mean square of the errors of forces, by that of the forces (of friction: of its bounds), which ends a
/// step.
constexpr double force_tolerance = 0.01;
/// The same for contacts that are met within the step.
constexpr double foreseen_tolerance = 0.05;
/// Times that bounds of friction are just those of the normal forces; from then on each time changes them
/// less.
constexpr int whole_bounds = 4;

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

ContactOutcome ContactResponse::outcome(std::size_t contact) const {
  const Law& law = laws_[contact];
  const ContactStatus status = !law.pushes        ? ContactStatus::open
                               : law.share == 1.0 ? ContactStatus::stick
                                                  : ContactStatus::slide;
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
void ContactResponse::update_calming(RememberedContact& contact, const Vec3& force, const Vec3& velocity,
                                     double most) const {
  contact.calming *= calming_kept;
  const bool turns = contact.lost > 0 || dot(velocity, contact.velocity) < 0.0;
  const double speed = length(velocity);
  if (!turns || speed == 0.0) return;
  const Vec3 foreseen =
      contact.force - (time_step_ * contact.stiffness * dot(contact.direction, velocity)) * contact.direction;
  contact.calming = std::min(std::max(contact.calming, length(force - foreseen) / speed), most);
}

/// Force by which a relative velocity at the end of the step is held, along and across the direction, N s/m.
double ContactResponse::resistance(const Law& law) const {
  return law.damping + time_step_ * law.stiffness;
}

/// Normal force at the end of a step if the contact pushes, N; negative where it would pull.
double ContactResponse::normal_force(const Law& law, const Vec3& velocity) const {
  return law.stiffness * law.depth - resistance(law) * dot(velocity, law.direction);
}

/// Share of the friction spring, with its damping, at which it pulls no more than a bound.
double ContactResponse::spring_share(const Law& law, const Vec3& velocity, double bound) const {
  const double pull = length(spring_force(law, velocity));
  return pull > bound ? bound / pull : 1.0;
}

/// Of the friction spring at the end of a step, with its damper and without bound, N.
Vec3 ContactResponse::spring_force(const Law& law, const Vec3& velocity) const {
  return -law.stiffness * law.slip - resistance(law) * across(velocity, law.direction);
}

/// Puts another share of the friction spring into a coupling.
void ContactResponse::set_share(Law& law, double share, fem::Coupling& coupling) {
  const double change = share - law.share;
  law.share = share;
  coupling.force -= (change * law.stiffness) * law.slip;
  add_across(change * law.stiffness, law.direction, coupling.stiffness);
  add_across(change * law.damping, law.direction, coupling.damping);
}

/// Puts the force along the direction into a coupling, or takes it out.
void ContactResponse::set_pushes(Law& law, bool pushes, fem::Coupling& coupling) {
  if (pushes == law.pushes) return;
  const double change = pushes ? 1.0 : -1.0;
  law.pushes = pushes;
  coupling.force += (change * law.stiffness * law.depth) * law.direction;
  coupling.stiffness = coupling.stiffness + outer_product(change * law.stiffness, law.direction);
  coupling.damping = coupling.damping + outer_product(change * law.damping, law.direction);
}

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities, double time_step,
                              std::vector<fem::Coupling>& couplings) {
  memory_.update(contacts);
  sides_.begin(threads, bodies, positions, contacts.size());
  time_step_ = time_step;
  has_iterate_ = false;
  has_guessed_bounds_ = false;
  renewals_ = 0;
  const std::size_t first = couplings.size();
  make_room(couplings, first + contacts.size());
  couplings.resize(first + contacts.size());
  resize_with_room(laws_, contacts.size());
  // What foresee() will ask for, so that a steady run asks in its first steps.
  make_room(unknown_, contacts.size());
  make_room(foreseen_, contacts.size() / 8);
  make_room(added_, contacts.size() / 8);
  for_each_searching(threads, contacts.size(), [&](std::size_t c, ExitSearch& search) {
    compute_one(bodies, contacts, c, positions, velocities, search, couplings[first + c]);
  });
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
    update_calming(remembered, force, velocity, most_calming * time_step_ * full);
  remembered.slip = bounded(across(remembered.slip, r), settings_.friction * contacts.depth[c]);
  const double last_normal = remembered.normal(velocity, time_step_);
  laws_[c] = {.stiffness = k,
              .damping = damping + remembered.calming,
              .depth = contacts.depth[c],
              .slip = remembered.slip,
              .direction = r};
  set_pushes(laws_[c], true, coupling);
  laws_[c].bound = settings_.friction * std::max(last_normal, 0.0);
  set_share(laws_[c], spring_share(laws_[c], velocity, laws_[c].bound), coupling);
  remembered.force = force;
  remembered.direction = r;
  remembered.velocity = velocity;
  remembered.stiffness = k;
  remembered.damping = laws_[c].damping;
  remembered.lost = 0;
}

Vec3 ContactResponse::force_at(const Law& law, const Vec3& velocity) const {
  const Vec3 friction = bounded(spring_force(law, velocity), law.bound);
  return std::max(normal_force(law, velocity), 0.0) * law.direction + friction;
}

/// Derivative of what the step minimises along the way from the last iterate to the solution, by the time
/// step, at a share of the way. The rest of the system is linear and in balance with the couplings at both
/// ends, so that its part follows from their forces there.
double ContactResponse::slope(const parallel::Threads& threads, double share) {
  return parallel::sum(threads, laws_.size(), partial_, [&](std::size_t c) {
    const Law& law = laws_[c];
    const Vec3 way = solved_[c].velocity - law.velocity;
    const Vec3 balance = law.force + share * (solved_[c].force - law.force);
    return dot(balance - force_at(law, law.velocity + share * way), way);
  });
}

/// The share of the way from the last iterate to the solution, or beyond, where the slope is zero.
double ContactResponse::search_line(const parallel::Threads& threads) {
  constexpr int halvings = 8;
  constexpr double furthest = 64.0;
  constexpr double flat = 0.1;
  const double at_iterate = slope(threads, 0.0);
  const double at_solution = slope(threads, 1.0);
  // A way that does not lead down comes of a bound that changed.
  if (!(at_iterate < 0.0) || std::abs(at_solution) <= -flat * at_iterate) return 1.0;
  double low = 0.0;
  double high = 1.0;
  // Weakening springs leads from stick to slide in many short steps, of one direction.
  while (high < furthest && slope(threads, high) < 0.0) {
    low = high;
    high *= 2.0;
  }
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(threads, middle) < 0.0 ? low : high) = middle;
  }
  return high;
}

bool ContactResponse::refine(const parallel::Threads& threads, std::span<const Vec3> velocities_end,
                             std::span<fem::Coupling> couplings) {
  resize_with_room(solved_, couplings.size());
  parallel::for_each(threads, couplings.size(), grain, [&](std::size_t c) {
    const Law& law = laws_[c];
    const Vec3 velocity = fem::relative(couplings[c], velocities_end);
    const double normal = normal_force(law, velocity);
    const double share = spring_share(law, velocity, law.bound);
    const double spring_error = (share - law.share) * length(spring_force(law, velocity));
    const bool right = (normal > 0.0) == law.pushes;
    const Vec3 force = fem::end_force(couplings[c], time_step_, velocities_end);
    const double bound_error = settings_.friction * std::max(normal, 0.0) - law.bound;
    solved_[c] = {velocity, force, std::max(normal, 0.0), right ? 0.0 : normal, spring_error, bound_error};
  });
  const auto squares = [&](double Solved::*value) {
    return parallel::sum(threads, couplings.size(), partial_,
                         [&](std::size_t c) { return solved_[c].*value * (solved_[c].*value); });
  };
  const double friction = settings_.friction;
  const double allowed = force_tolerance * force_tolerance * squares(&Solved::normal);
  const bool fits = squares(&Solved::normal_error) <= allowed &&
                    squares(&Solved::spring_error) <= friction * friction * allowed;
  const bool done = fits && squares(&Solved::bound_error) <= friction * friction * allowed;
  const double share = fits || !has_iterate_ ? 1.0 : search_line(threads);
  double renewal = fits ? 1.0 / std::max(1, ++renewals_ - whole_bounds) : 0.0;
  if (std::exchange(has_guessed_bounds_, false)) renewal = 1.0;
  has_iterate_ = true;
  parallel::for_each(threads, couplings.size(), grain, [&](std::size_t c) {
    Law& law = laws_[c];
    law.velocity += share * (solved_[c].velocity - law.velocity);
    law.force += share * (solved_[c].force - law.force);
    if (done) return;
    law.bound += renewal * solved_[c].bound_error;
    take_iterate(law, couplings[c]);
  });
  return !done;
}

/// Makes the coupling fit the iterate of its law.
void ContactResponse::take_iterate(Law& law, fem::Coupling& coupling) const {
  const double normal = normal_force(law, law.velocity);
  set_pushes(law, normal > 0.0, coupling);
  set_share(law, spring_share(law, law.velocity, law.bound), coupling);
  if (law.pushes || law.share != 0.0) return;
  // An open contact has no stiffness at all, not what rounding leaves of it: preconditioners pass it over.
  coupling.force = {};
  coupling.stiffness = {};
  coupling.damping = {};
}

void ContactResponse::foresee_one(const Bodies& bodies, const Contacts& contacts, std::size_t c,
                                  std::span<const Vec3> positions_end, std::span<const Vec3> velocities_end,
                                  ExitSearch& search, Foreseen& foreseen) const {
  const Index point = contacts.point[c];
  const Index body = contacts.body[c];
  const Vec3& r = contacts.direction[c];
  const double k = sides_.share(bodies, positions_end, contacts, c, search) *
                   stiffness(at(bodies.body_of_point(), point), body);
  fem::Coupling coupling = coupling_of(point, at(bodies.tets(), contacts.tet[c]), contacts.weights[c]);
  const Vec3 velocity = fem::relative(coupling, velocities_end);
  // Where it was before the step, along the straight way that it came: outside.
  const double depth = std::min(contacts.depth[c] + time_step_ * dot(velocity, r), 0.0);
  Law law{.stiffness = k, .damping = 0.0, .depth = depth, .slip = {}, .direction = r};
  const double normal = normal_force(law, velocity);
  law.velocity = velocity;
  law.bound = settings_.friction * std::max(normal, 0.0);
  take_iterate(law, coupling);
  foreseen = {.law = law, .coupling = coupling, .remembered = {}, .force = std::max(normal, 0.0)};
  foreseen.remembered = {.point = point,
                         .body = body,
                         .seen = 1,
                         .foreseen = true,
                         .slip = {},
                         .force = (k * depth) * r,
                         .direction = r,
                         .velocity = velocity,
                         .stiffness = k,
                         .damping = 0.0,
                         .calming = 0.0,
                         .side = {}};
}

bool ContactResponse::foresee(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions_end,
                              std::span<const Vec3> velocities_end, std::vector<fem::Coupling>& couplings) {
  memory_.list_unknown(contacts, unknown_);
  resize_with_room(foreseen_, unknown_.size());
  for_each_searching(threads, unknown_.size(), [&](std::size_t i, ExitSearch& search) {
    foresee_one(bodies, contacts, unknown_[i], positions_end, velocities_end, search, foreseen_[i]);
  });
  std::erase_if(foreseen_, [](const Foreseen& contact) { return contact.force == 0.0; });
  const double met = parallel::sum(threads, foreseen_.size(), partial_,
                                   [&](std::size_t i) { return foreseen_[i].force * foreseen_[i].force; });
  const double acting = parallel::sum(threads, laws_.size(), partial_,
                                      [&](std::size_t c) { return solved_[c].normal * solved_[c].normal; });
  if (met <= foreseen_tolerance * foreseen_tolerance * acting) return false;
  make_room(laws_, laws_.size() + foreseen_.size());
  make_room(couplings, couplings.size() + foreseen_.size());
  make_room(added_, foreseen_.size());
  added_.clear();
  for (const Foreseen& contact : foreseen_) {
    laws_.push_back(contact.law);
    couplings.push_back(contact.coupling);
    added_.push_back(contact.remembered);
  }
  memory_.add(added_);
  renewals_ = 0;
  has_guessed_bounds_ = true;
  return true;
}

}  // namespace palpate
