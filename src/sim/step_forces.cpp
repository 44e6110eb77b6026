#include "sim/step_forces.hpp"

#include <algorithm>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 256;

}  // namespace

void StepForces::take(const parallel::Threads& threads, std::span<const fem::Coupling> couplings,
                      const CouplingRanges& ranges, const ContactResponse& response, double time_step,
                      std::span<const Vec3> velocities) {
  resize_with_room(all_, couplings.size());
  const std::size_t contact_count = couplings.size() - ranges.first_contact;
  resize_with_room(contacts_, contact_count);
  parallel::for_each(threads, couplings.size(), grain, [&](std::size_t i) {
    const fem::Coupling& coupling = couplings[i];
    all_[i] = fem::end_force(coupling, time_step, velocities);
    if (i < ranges.first_contact) return;
    const ContactOutcome outcome =
        response.outcome(i - ranges.first_contact, fem::relative(coupling, velocities));
    const std::array<double, 5>& c = coupling.coefficients;
    contacts_[i - ranges.first_contact] = {.points = coupling.points,
                                           .weights = {-c[1], -c[2], -c[3], -c[4]},
                                           .depth = outcome.depth,
                                           .direction = outcome.direction,
                                           .force = all_[i],
                                           .status = outcome.status,
                                           .speculative = i >= ranges.first_speculative};
  });
  const auto first = all_.begin() + static_cast<std::ptrdiff_t>(ranges.first_tie);
  ties_.assign(first, all_.begin() + static_cast<std::ptrdiff_t>(ranges.first_contact));
}

void StepForces::sum_over_bodies(const Bodies& bodies, std::span<Vec3> sums) const {
  std::fill(sums.begin(), sums.end(), Vec3{});
  for (const ActedContact& contact : contacts_) {
    at(sums, at(bodies.body_of_point(), contact.points[0])) += contact.force;
    at(sums, at(bodies.body_of_point(), contact.points[1])) -= contact.force;
  }
}

/// Tets keep the order of their corners, so it is there.
Index tet_of(const ActedContact& contact, const Bodies& bodies) {
  const Tet corners{contact.points[1], contact.points[2], contact.points[3], contact.points[4]};
  for (const Index tet : bodies.point_tets()[corners[0]]) {
    if (at(bodies.tets(), tet) == corners) return tet;
  }
  return -1;
}

ContactForces contact_forces_of(std::span<const ActedContact> contacts, const Bodies& bodies) {
  ContactForces all;
  for (const ActedContact& c : contacts) {
    const double normal = dot(c.force, c.direction);
    all.point.push_back(c.points[0]);
    all.body.push_back(at(bodies.body_of_point(), c.points[1]));
    all.tet.push_back(tet_of(c, bodies));
    all.weights.push_back(c.weights);
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
