#include "sim/wrench.hpp"

#include <algorithm>
#include <utility>

#include <palpate/error.hpp>

namespace palpate {

void check_about(const Vec3& about) {
  if (!is_finite(about))
    throw Error("wrench", "about", "a number that is not finite", "three finite numbers");
}

Wrench moved_to(const Wrench& wrench, const Vec3& about) {
  check_about(about);
  return {wrench.force, wrench.torque + cross(wrench.about - about, wrench.force), about};
}

Wrench wrench_on(std::span<const ActedContact> contacts, const Bodies& bodies,
                 std::span<const Vec3> positions, Index body, const Vec3& about) {
  Wrench sum{.force = {}, .torque = {}, .about = about};
  for (const ActedContact& contact : contacts) {
    const Index inside = contact.body_inside(bodies);
    const Index penetrated = contact.penetrated_body(bodies);
    if ((inside == body) == (penetrated == body)) continue;  // both sides are in the body, or none is
    add_force(inside == body ? contact.force : -contact.force, place_of(contact, positions), sum);
  }
  return sum;
}

std::vector<PairWrench> wrenches_of_pairs(std::span<const ActedContact> contacts, const Bodies& bodies,
                                          std::span<const Vec3> positions, std::span<const Vec3> centers) {
  std::vector<PairWrench> pairs;
  const auto of = [](const PairWrench& pair) { return std::pair(pair.body_a, pair.body_b); };
  for (const ActedContact& contact : contacts) {
    const Index inside = contact.body_inside(bodies);
    const Index penetrated = contact.penetrated_body(bodies);
    const Index low = std::min(inside, penetrated);
    const Index high = std::max(inside, penetrated);
    const auto place = std::ranges::lower_bound(pairs, std::pair(low, high), {}, of);
    const bool known = place != pairs.end() && of(*place) == std::pair(low, high);
    PairWrench& pair =
        known ? *place
              : *pairs.insert(place,
                              PairWrench{.body_a = low,
                                         .body_b = high,
                                         .on_b = {.force = {}, .torque = {}, .about = at(centers, high)}});
    if (contact.status != ContactStatus::open) ++pair.contacts;
    pair.normal += dot(contact.force, contact.direction);
    if (low == high) continue;
    add_force(inside == high ? contact.force : -contact.force, place_of(contact, positions), pair.on_b);
  }
  return pairs;
}

Vec3 center_of_mass(const Body& body, std::span<const double> masses, std::span<const Vec3> positions) {
  Vec3 sum;
  double mass = 0.0;
  for (Index p = body.points.begin; p < body.points.end; ++p) {
    sum += at(masses, p) * at(positions, p);
    mass += at(masses, p);
  }
  return (1.0 / mass) * sum;
}

}  // namespace palpate
