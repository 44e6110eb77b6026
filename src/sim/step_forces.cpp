#include "sim/step_forces.hpp"

#include <algorithm>
#include <span>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t force_grain = 256;

}  // namespace

void StepForces::take(const parallel::Threads& threads, std::span<const fem::Coupling> couplings,
                      const CouplingRanges& ranges, const ContactResponse& response, double time_step,
                      std::span<const Vec3> velocities) {
  resize_with_room(all_, couplings.size());
  const std::size_t contact_count = couplings.size() - ranges.first_contact;
  resize_with_room(contacts_, contact_count);
  parallel::for_each(threads, couplings.size(), force_grain, [&](std::size_t i) {
    const fem::Coupling& coupling = couplings[i];
    all_[i] = fem::end_force(coupling, time_step, velocities);
    if (i < ranges.first_contact) return;
    const ContactOutcome outcome =
        response.outcome(i - ranges.first_contact, fem::relative(coupling, velocities));
    contacts_[i - ranges.first_contact] = {
        .points = coupling.points,
        .coefficients = coupling.coefficients,
        .of_edge = response.is_of_edge(i - ranges.first_contact),
        .depth = outcome.depth,
        .direction = outcome.direction,
        .force = all_[i],
        .status = outcome.status,
        .speculative = i >= ranges.first_speculative || outcome.depth < 0.0};
  });
  const auto first = all_.begin() + static_cast<std::ptrdiff_t>(ranges.first_tie);
  ties_.assign(first, all_.begin() + static_cast<std::ptrdiff_t>(ranges.first_contact));
}

void StepForces::sum_over_bodies(const Bodies& bodies, std::span<Vec3> sums) const {
  std::fill(sums.begin(), sums.end(), Vec3{});
  for (const ActedContact& contact : contacts_) {
    at(sums, contact.body_inside(bodies)) += contact.force;
    at(sums, contact.penetrated_body(bodies)) -= contact.force;
  }
}

Vec3 place_of(const ActedContact& contact, std::span<const Vec3> positions) {
  if (!contact.of_edge) return at(positions, contact.points[0]);
  return contact.coefficients[0] * at(positions, contact.points[0]) +
         contact.coefficients[1] * at(positions, contact.points[1]);
}

Index tet_of(const ActedContact& contact, const Bodies& bodies) {
  const auto corners = std::span(contact.points).first(contact.all_points()).subspan(contact.own_points());
  const auto has = [&](Index tet) {
    const Tet& all = at(bodies.tets(), tet);
    return std::ranges::all_of(corners, [&](Index p) { return std::ranges::find(all, p) != all.end(); });
  };
  const std::span<const Index> tets = bodies.point_tets()[corners[0]];
  const auto found = std::ranges::find_if(tets, has);
  return found == tets.end() ? -1 : *found;
}

namespace {

/// Weights of a contact's position in a tet that contains the contact's points of the penetrated body.
std::array<double, 4> weights_in(const ActedContact& contact, const Tet& tet) {
  std::array<double, 4> weights{};
  for (std::size_t k = contact.own_points(); k < contact.all_points(); ++k)
    at(weights, std::ranges::find(tet, contact.points[k]) - tet.begin()) = -contact.coefficients[k];
  return weights;
}

Index edge_of(const ActedContact& contact, const Bodies& bodies) {
  if (!contact.of_edge) return -1;
  const auto& [p, q, a, b, c] = contact.points;
  const std::span<const Index> edges = bodies.point_edges()[p];
  const auto joins = [&, other = q](Index edge) {
    const Edge& ends = at(bodies.edges(), edge);
    return ends[0] == other || ends[1] == other;
  };
  const auto found = std::ranges::find_if(edges, joins);
  return found == edges.end() ? -1 : *found;
}

}  // namespace

ContactForces contact_forces_of(std::span<const ActedContact> contacts, const Bodies& bodies) {
  ContactForces all;
  for (const ActedContact& c : contacts) {
    const double normal = dot(c.force, c.direction);
    const Index tet = tet_of(c, bodies);
    all.point.push_back(c.of_edge && c.coefficients[1] > c.coefficients[0] ? c.points[1] : c.points[0]);
    all.edge.push_back(edge_of(c, bodies));
    all.body.push_back(c.penetrated_body(bodies));
    all.tet.push_back(tet);
    all.weights.push_back(weights_in(c, at(bodies.tets(), tet)));
    all.depth.push_back(c.depth);
    all.direction.push_back(c.direction);
    all.normal.push_back(normal);
    all.friction.push_back(c.force - normal * c.direction);
    all.status.push_back(c.status);
    all.speculative.push_back(c.speculative ? 1 : 0);
  }
  return all;
}

}  // namespace palpate
