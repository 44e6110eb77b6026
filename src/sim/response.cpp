#include "sim/response.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "mesh/faces.hpp"
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

/// Mean over the tets of a body of the smallest height at rest.
double mean_height(const Bodies& bodies, Index body) {
  const Range tets = at(bodies.bodies(), body).tets;
  double sum = 0.0;
  for (Index t = tets.begin; t < tets.end; ++t) {
    const Tet& corners = at(bodies.tets(), t);
    const auto rest = [&](std::size_t i) { return at(bodies.points_rest(), corners[i]); };
    const double six_volumes = dot(cross(rest(1) - rest(0), rest(2) - rest(0)), rest(3) - rest(0));
    double largest = 0.0;  // twice the area of a face
    for (const auto& [i, j, k] : outward_face)
      largest = std::max(largest, length(cross(rest(j) - rest(i), rest(k) - rest(i))));
    if (largest > 0.0) sum += six_volumes / largest;
  }
  return tets.size() > 0 ? sum / tets.size() : 0.0;
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

}  // namespace

ContactResponse::ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                                 std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                                 std::span<const double> masses, std::span<const std::uint8_t> moves)
    : settings_(settings),
      body_compliance_(bodies.bodies().size(), 0.0),
      rims_(bodies.bodies().size()),
      masses_(masses),
      moves_(moves) {
  if (settings.stiffness)
    check(*settings.stiffness > 0.0, "stiffness", *settings.stiffness, "a finite number > 0");
  check(settings.damping >= 0.0, "damping", settings.damping, "a finite number >= 0");
  check(settings.friction >= 0.0, "friction", settings.friction, "a finite number >= 0");
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const double h = mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean;
    at(rims_, b).outer = 0.25 * h;
    at(rims_, b).inner = std::min(0.075 * mean_height(bodies, b), 0.5 * at(rims_, b).outer);
    if (at(obstacles, b) != 0) continue;
    at(body_compliance_, b) = 1.0 / (10.0 * at(materials, b).young_modulus * h);
  }
}

double ContactResponse::stiffness(Index body_a, Index body_b) const {
  return settings_.stiffness.value_or(1.0 / (at(body_compliance_, body_a) + at(body_compliance_, body_b)));
}

double ContactResponse::reduced_mass(Index point, const Tet& tet,
                                     const std::array<double, 4>& weights) const {
  double inverse = at(moves_, point) != 0 ? 1.0 / at(masses_, point) : 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (at(moves_, tet[i]) != 0) inverse += weights[i] * weights[i] / at(masses_, tet[i]);
  }
  return inverse > 0.0 ? 1.0 / inverse : 0.0;
}

double ContactResponse::side_share(const Bodies& bodies, std::span<const Vec3> positions,
                                   const Contacts& contacts, std::size_t c, ExitSearch& search) const {
  const Rim& rim = at(rims_, contacts.body[c]);
  const double distance = search.distance_to_side(
      bodies, positions, contacts.tet[c], at(positions, contacts.point[c]), contacts.direction[c], rim.outer);
  return std::max(0.0, distance - rim.inner) / (rim.outer - rim.inner);
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

/// Normal force at the end of a step if the contact pushes, N; negative where it would pull.
double ContactResponse::normal_force(const Law& law, const Vec3& velocity) const {
  return law.stiffness * (law.depth - (time_step_ + law.lag) * dot(velocity, law.direction));
}

/// Share of the friction spring, with its damping, at which it pulls no more than mu times the normal force.
double ContactResponse::spring_share(const Law& law, const Vec3& velocity, double normal_force) const {
  const double bound = settings_.friction * std::max(normal_force, 0.0);
  const double pull = law.stiffness * length(stretch(law, velocity));
  return pull > bound ? bound / pull : 1.0;
}

/// Of the friction spring at the end of a step, with what its damper adds, m.
Vec3 ContactResponse::stretch(const Law& law, const Vec3& velocity) const {
  return law.slip + (time_step_ + law.lag) * across(velocity, law.direction);
}

/// Puts another share of the friction spring into a coupling.
void ContactResponse::set_share(Law& law, double share, fem::Coupling& coupling) {
  const double change = (share - law.share) * law.stiffness;
  law.share = share;
  coupling.force -= change * law.slip;
  add_across(change, law.direction, coupling.stiffness);
  add_across(change * law.lag, law.direction, coupling.damping);
}

/// Puts the force along the direction into a coupling, or takes it out.
void ContactResponse::set_pushes(Law& law, bool pushes, fem::Coupling& coupling) {
  if (pushes == law.pushes) return;
  const double change = pushes ? law.stiffness : -law.stiffness;
  law.pushes = pushes;
  coupling.force += (change * law.depth) * law.direction;
  coupling.stiffness = coupling.stiffness + outer_product(change, law.direction);
  coupling.damping = coupling.damping + outer_product(change * law.lag, law.direction);
}

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities, double time_step,
                              std::vector<fem::Coupling>& couplings) {
  memory_.update(contacts);
  time_step_ = time_step;
  resize_with_room(couplings, contacts.size());
  resize_with_room(laws_, contacts.size());
  const std::size_t chunks = parallel::chunk_count(contacts.size(), grain);
  if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
  parallel::for_chunks(
      threads, contacts.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        for (std::size_t c = begin; c < end; ++c) {
          compute_one(bodies, contacts, c, positions, velocities, searches_[chunk], couplings[c]);
        }
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
  const double k = side_share(bodies, positions, contacts, c, search) * full;
  const double critical = 2.0 * std::sqrt(k * reduced_mass(point, tet, w));
  const double damping = settings_.damping * std::max(critical, stiff_damping * k * time_step_);

  coupling = {};
  coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
  coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
  const Vec3 velocity = fem::relative(coupling, velocities);
  const Vec3 force = k * contacts.depth[c] * r;
  RememberedContact& remembered = memory_.of_contact(c);
  if (remembered.seen > 1) remembered.slip += time_step_ * velocity;
  if (remembered.seen > 1 || remembered.lost > 0)
    update_calming(remembered, force, velocity, most_calming * time_step_ * full);
  remembered.slip = bounded(across(remembered.slip, r), settings_.friction * contacts.depth[c]);
  const double last_normal = remembered.normal(velocity, time_step_);
  const double lag = k > 0.0 ? (damping + remembered.calming) / k : 0.0;
  laws_[c] = {
      .stiffness = k, .lag = lag, .depth = contacts.depth[c], .slip = remembered.slip, .direction = r};
  set_pushes(laws_[c], true, coupling);
  set_share(laws_[c], spring_share(laws_[c], velocity, last_normal), coupling);
  remembered.force = force;
  remembered.direction = r;
  remembered.velocity = velocity;
  remembered.stiffness = k;
  remembered.lag = lag;
  remembered.lost = 0;
}

bool ContactResponse::refine(const parallel::Threads& threads, std::span<const Vec3> velocities_end,
                             std::span<fem::Coupling> couplings) {
  resize_with_room(refined_, couplings.size());
  parallel::for_each(threads, couplings.size(), grain, [&](std::size_t c) {
    const Law& law = laws_[c];
    const Vec3 velocity = fem::relative(couplings[c], velocities_end);
    const double normal = normal_force(law, velocity);
    const double share = spring_share(law, velocity, normal);
    const double spring_error = (share - law.share) * law.stiffness * length(stretch(law, velocity));
    const bool right = (normal > 0.0) == law.pushes;
    refined_[c] = {share, normal, right ? 0.0 : normal, spring_error};
  });
  const auto squares = [&](double Refined::*value) {
    return parallel::sum(threads, couplings.size(), partial_,
                         [&](std::size_t c) { return refined_[c].*value * (refined_[c].*value); });
  };
  const double allowed = force_tolerance * force_tolerance * squares(&Refined::normal);
  const double friction = settings_.friction;
  if (squares(&Refined::normal_error) <= allowed &&
      squares(&Refined::spring_error) <= friction * friction * allowed) {
    return false;
  }
  parallel::for_each(threads, couplings.size(), grain, [&](std::size_t c) {
    set_pushes(laws_[c], refined_[c].normal > 0.0, couplings[c]);
    set_share(laws_[c], refined_[c].share, couplings[c]);
  });
  return true;
}

}  // namespace palpate
