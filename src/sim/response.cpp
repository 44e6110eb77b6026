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

}  // namespace

ContactResponse::ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                                 std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                                 std::span<const double> masses, std::span<const std::uint8_t> moves)
    : settings_(settings),
      body_compliance_(bodies.bodies().size(), 0.0),
      rim_width_(bodies.bodies().size(), 0.0),
      masses_(masses),
      moves_(moves) {
  if (settings.stiffness)
    check(*settings.stiffness > 0.0, "stiffness", *settings.stiffness, "a finite number > 0");
  check(settings.damping >= 0.0, "damping", settings.damping, "a finite number >= 0");
  check(settings.friction >= 0.0, "friction", settings.friction, "a finite number >= 0");
  check(settings.friction_speed > 0.0, "friction_speed", settings.friction_speed, "a finite number > 0");
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const double h = mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean;
    at(rim_width_, b) = 0.25 * h;
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
                                   const Contacts& contacts, std::size_t c) const {
  const double width = at(rim_width_, contacts.body[c]);
  const SurfacePoint side = nearest_side_exit(bodies, positions, contacts.tet[c],
                                              at(positions, contacts.point[c]), contacts.direction[c], width);
  return side.distance / width;
}

/// Contacts are sorted by (point, body), so those that were there before are found in one pass.
void ContactResponse::carry_slips(const Contacts& contacts) {
  std::swap(slips_, last_slips_);
  resize_with_room(slips_, contacts.size());
  std::size_t last = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto key = std::pair(contacts.point[c], contacts.body[c]);
    const auto key_of = [&](std::size_t i) { return std::pair(last_slips_[i].point, last_slips_[i].body); };
    while (last < last_slips_.size() && key_of(last) < key) ++last;
    const bool known = last < last_slips_.size() && key_of(last) == key;
    slips_[c] = {key.first, key.second, known, known ? last_slips_[last].slip : Vec3{}};
  }
}

void ContactResponse::add_friction(double k, double depth, double damping, const Vec3& r,
                                   const Vec3& velocity, double time_step, Vec3& slip,
                                   fem::Coupling& coupling) const {
  const double most = settings_.friction * depth;  // slip at which the spring pulls mu k d
  if (most <= 0.0) {
    slip = {};
    return;
  }
  const auto across = [&](const Vec3& a) { return a - dot(a, r) * r; };
  const auto bounded = [&](const Vec3& a) { return length(a) > most ? (most / length(a)) * a : a; };
  const Vec3 sliding = across(velocity);
  slip = bounded(across(slip));
  const Vec3 ahead = slip + time_step * sliding;
  const auto add_across = [&](double s, fem::SymmetricMatrix3& m) {
    m.xx += s * (1.0 - r.x * r.x);
    m.yy += s * (1.0 - r.y * r.y);
    m.zz += s * (1.0 - r.z * r.z);
    m.xy -= s * r.x * r.y;
    m.xz -= s * r.x * r.z;
    m.yz -= s * r.y * r.z;
  };
  const double viscosity = most * k / std::max(length(sliding), settings_.friction_speed);
  if (length(ahead) > most) {
    add_across(viscosity, coupling.damping);
    return;
  }
  // The spring carries the load; the viscosity calms contacts that tremble on a rim.
  constexpr double share_while_sticking = 0.5;
  add_across(damping + share_while_sticking * viscosity, coupling.damping);
  add_across(k, coupling.stiffness);
  coupling.force -= k * slip;
}

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities, double time_step,
                              std::vector<fem::Coupling>& couplings) {
  carry_slips(contacts);
  resize_with_room(couplings, contacts.size());
  parallel::for_each(threads, contacts.size(), 256, [&](std::size_t c) {
    const Index point = contacts.point[c];
    const Tet& tet = at(bodies.tets(), contacts.tet[c]);
    const std::array<double, 4>& w = contacts.weights[c];
    const Vec3& r = contacts.direction[c];
    const double share = side_share(bodies, positions, contacts, c);
    const double k = share * stiffness(at(bodies.body_of_point(), point), contacts.body[c]);
    const double damping = 2.0 * settings_.damping * std::sqrt(k * reduced_mass(point, tet, w));

    fem::Coupling coupling;
    coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
    coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
    coupling.force = k * contacts.depth[c] * r;
    coupling.stiffness = outer_product(k, r);
    coupling.damping = outer_product(damping, r);
    const Vec3 velocity = fem::relative(coupling, velocities);
    Vec3& slip = slips_[c].slip;
    if (slips_[c].known)
      slip += time_step * velocity;  // by the last step; add_friction() keeps what is across r
    add_friction(k, contacts.depth[c], damping, r, velocity, time_step, slip, coupling);
    couplings[c] = coupling;
  });
}

}  // namespace palpate
