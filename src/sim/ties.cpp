#include "sim/ties.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "mesh/unused_points.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a);
}

void check_index(Index i, std::size_t count, const std::string& where) {
  if (i >= 0 && static_cast<std::size_t>(i) < count) return;
  throw Error("ties", where, std::to_string(i), "an index below " + std::to_string(count));
}

void check(const Tie& tie, const Bodies& bodies, const std::string& where) {
  check_index(tie.point, bodies.points_rest().size(), where + ".point");
  check_used(bodies, tie.point, "ties", where + ".point");
  check_index(tie.tet, bodies.tets().size(), where + ".tet");
  if (bodies.body_of(at(bodies.tets(), tie.tet)) == at(bodies.body_of_point(), tie.point))
    throw Error("ties", where, "a tet of the point's own body", "a tet of another body");
  const double stiffness = tie.stiffness.value_or(1.0);
  if (!(stiffness > 0.0) || !std::isfinite(stiffness))
    throw Error("ties", where + ".stiffness", number_text(stiffness), "a finite number > 0");
}

/// Barycentric weights of a point, which may be outside the tet. So force and reaction of the tie act at one
/// place, without a torque.
std::array<double, 4> weights_of(const Vec3& p, const Tet& tet, std::span<const Vec3> positions,
                                 const std::string& where) {
  const std::array<Vec3, 4> c{at(positions, tet[0]), at(positions, tet[1]), at(positions, tet[2]),
                              at(positions, tet[3])};
  const double whole = six_volumes(c[0], c[1], c[2], c[3]);
  if (!(whole > 0.0)) throw Error("ties", where, "a tet without volume", "a tet with volume");
  const double w1 = six_volumes(c[0], p, c[2], c[3]) / whole;
  const double w2 = six_volumes(c[0], c[1], p, c[3]) / whole;
  const double w3 = six_volumes(c[0], c[1], c[2], p) / whole;
  return {1.0 - w1 - w2 - w3, w1, w2, w3};
}

/// The matrix k I.
fem::SymmetricMatrix3 in_all_directions(double k) {
  return {k, k, k, 0.0, 0.0, 0.0};
}

}  // namespace

std::vector<HeldTie> held_ties(const std::vector<Tie>& ties, const Bodies& bodies,
                               std::span<const Vec3> positions) {
  std::vector<HeldTie> held;
  for (std::size_t i = 0; i < ties.size(); ++i) {
    const std::string where = std::string(1, '[').append(std::to_string(i)).append(1, ']');
    check(ties[i], bodies, where);
    const Tet& tet = at(bodies.tets(), ties[i].tet);
    held.push_back({ties[i], weights_of(at(positions, ties[i].point), tet, positions, where)});
  }
  return held;
}

std::vector<std::array<Index, 2>> tied_points(const std::vector<HeldTie>& ties, const Bodies& bodies,
                                              const ContactResponse& response) {
  std::vector<std::array<Index, 2>> tied;
  for (const auto& [tie, weights] : ties) {
    const Index body = bodies.body_of(at(bodies.tets(), tie.tet));
    const double of_contact = response.stiffness(at(bodies.body_of_point(), tie.point), body);
    if (tie.stiffness.value_or(of_contact) >= of_contact) tied.push_back({tie.point, body});
  }
  std::ranges::sort(tied);
  return tied;
}

Ties::Ties(const std::vector<HeldTie>& ties, const Bodies& bodies, std::span<const double> masses,
           std::span<const std::uint8_t> moves, const ContactResponse& response) {
  for (const auto& [tie, w] : ties) {
    const Tet& tet = at(bodies.tets(), tie.tet);
    const double k = tie.stiffness
                         ? *tie.stiffness
                         : response.stiffness(at(bodies.body_of_point(), tie.point), bodies.body_of(tet));
    fem::Coupling coupling;
    coupling.points = {tie.point, tet[0], tet[1], tet[2], tet[3]};
    coupling.coefficients = {1.0, -w[0], -w[1], -w[2], -w[3]};
    double inverse_mass = 0.0;
    for (std::size_t j = 0; j < 5; ++j) {
      const double c = coupling.coefficients[j];
      if (at(moves, coupling.points[j]) != 0) inverse_mass += c * c / at(masses, coupling.points[j]);
    }
    coupling.stiffness = in_all_directions(k);
    coupling.damping = in_all_directions(inverse_mass > 0.0 ? 2.0 * std::sqrt(k / inverse_mass) : 0.0);
    couplings_.push_back(coupling);
  }
}

void Ties::append(std::span<const Vec3> positions, std::vector<fem::Coupling>& couplings) const {
  for (const fem::Coupling& tie : couplings_) {
    fem::Coupling& coupling = couplings.emplace_back(tie);
    coupling.force = -tie.stiffness.xx * fem::relative(tie, positions);
  }
}

}  // namespace palpate
