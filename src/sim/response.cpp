#include "sim/response.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <palpate/error.hpp>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"

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

void ContactResponse::compute(const parallel::Threads& threads, const Bodies& bodies,
                              const Contacts& contacts, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities, std::vector<fem::Coupling>& couplings) const {
  couplings.resize(contacts.size());
  parallel::for_each(threads, contacts.size(), 256, [&](std::size_t c) {
    const Index point = contacts.point[c];
    const Tet& tet = at(bodies.tets(), contacts.tet[c]);
    const std::array<double, 4>& w = contacts.weights[c];
    const Vec3& r = contacts.direction[c];
    const double share = side_share(bodies, positions, contacts, c);
    const double k = share * stiffness(at(bodies.body_of_point(), point), contacts.body[c]);
    const double normal_force = k * contacts.depth[c];

    fem::Coupling coupling;
    coupling.points = {point, tet[0], tet[1], tet[2], tet[3]};
    coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
    const Vec3 velocity = fem::relative(coupling, velocities);
    const double sliding_speed = length(velocity - dot(velocity, r) * r);
    const double along = 2.0 * settings_.damping * std::sqrt(k * reduced_mass(point, tet, w));
    const double across =
        settings_.friction * normal_force / std::max(sliding_speed, settings_.friction_speed);
    coupling.force = normal_force * r;
    coupling.stiffness = outer_product(k, r);
    coupling.damping = outer_product(along - across, r);
    coupling.damping.xx += across;
    coupling.damping.yy += across;
    coupling.damping.zz += across;
    couplings[c] = coupling;
  });
}

}  // namespace palpate
