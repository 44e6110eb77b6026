#pragma once

#include <span>
#include <vector>

#include <palpate/forces.hpp>
#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "sim/step_forces.hpp"

/// Sums of contact forces. The arm of a force and of its reaction is the position of the point that is
/// inside.
namespace palpate {

/// Throws Error on a reference point that is not finite.
void check_about(const Vec3& about);

/// The wrench of contacts on a body, about a point. O(contacts).
[[nodiscard]] Wrench wrench_on(std::span<const ActedContact> contacts, const Bodies& bodies,
                               std::span<const Vec3> positions, Index body, const Vec3& about);

/// The wrenches between each two bodies in contact, sorted by (body_a, body_b).
/// \param centers  (n_bodies x 3) reference points of torques, m
///
/// O(contacts log).
[[nodiscard]] std::vector<PairWrench> wrenches_of_pairs(std::span<const ActedContact> contacts,
                                                        const Bodies& bodies, std::span<const Vec3> positions,
                                                        std::span<const Vec3> centers);

/// Adds a force at a place.
inline void add_force(const Vec3& force, const Vec3& place, Wrench& sum) {
  sum.force += force;
  sum.torque += cross(place - sum.about, force);
}

/// The wrench of forces on the wanted points of a range, about a point. O(points of the range).
template <class Wanted>
Wrench wrench_of_points(std::span<const Vec3> forces, std::span<const Vec3> positions, Range points,
                        const Vec3& about, Wanted&& wanted) {
  Wrench sum{.force = {}, .torque = {}, .about = about};
  for (Index p = points.begin; p < points.end; ++p) {
    if (!wanted(p)) continue;
    add_force(forces[static_cast<std::size_t>(p)], positions[static_cast<std::size_t>(p)], sum);
  }
  return sum;
}

/// Centre of mass of a body. O(points of the body).
[[nodiscard]] Vec3 center_of_mass(const Body& body, std::span<const double> masses,
                                  std::span<const Vec3> positions);

}  // namespace palpate
