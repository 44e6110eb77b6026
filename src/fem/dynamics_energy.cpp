// Energies of a Dynamics, and the limit of what contacts give to bodies that rotate.
#include <algorithm>
#include <array>
#include <cmath>

#include "fem/dynamics.hpp"
#include "fem/rigid_motion.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {

double Dynamics::kinetic_energy() {
  return parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return system_.free()[i] != 0 ? 0.5 * masses_[i] * squared_length(velocities_[i]) : 0.0;
  });
}

/// Whether the elastic energy of smoothed tets is not that of their elements.
bool Dynamics::has_energy_of_domains() const {
  return elements_.smoothing().is_viscous() || elements_.has_ambient();
}

/// The elastic energy of an element, J; of a smoothed tet only without has_energy_of_domains().
double Dynamics::energy_of_element(Index element) const {
  const bool has_more =
      elements_.viscosity().has(static_cast<std::size_t>(element)) || elements_.has_ambient(element);
  return has_more ? elements_.energy(element, positions_) : elements_.energy(element);
}

double Dynamics::elastic_energy() {
  update_elements();
  const bool apart = has_energy_of_domains();
  const double sum =
      parallel::sum(threads_, static_cast<std::size_t>(elements_.size()), partial_, [&](std::size_t e) {
        const auto element = static_cast<Index>(e);
        return apart && elements_.is_smoothed(element) ? 0.0 : energy_of_element(element);
      });
  return apart ? sum + elements_.smoothed_energy(threads_, partial_) : sum;
}

/// Elastic and kinetic energy of a free body, J. O(elements and points of the body).
double Dynamics::energy_of_body(std::size_t body) const {
  double energy = 0.0;
  for (const Index e : elements_of_body_[static_cast<Index>(body)]) energy += energy_of_element(e);
  const Range points = bodies_[body].points;
  for (Index i = points.begin; i < points.end; ++i)
    energy += 0.5 * at(masses_, i) * squared_length(at(velocities_, i));
  return energy;
}

/// Whether all that changes the energy of a body in a step is known, but for what contacts do: it is free,
/// and no force turns with it.
bool Dynamics::has_known_energy(std::size_t body) const {
  if (turning_bodies_[body] == 0) return false;
  if (has_energy_of_domains() && std::ranges::any_of(elements_of_body_[static_cast<Index>(body)],
                                                     [&](Index e) { return elements_.is_smoothed(e); }))
    return false;
  const Range points = bodies_[body].points;
  const auto turns = [&](const Vec3& force) { return force != Vec3{}; };
  return turning_forces_.empty() ||
         std::none_of(turning_forces_.begin() + points.begin, turning_forces_.begin() + points.end, turns);
}

/// Stores the energies of free bodies at the start of a step.
void Dynamics::begin_energies() {
  if (second_order_) return;
  update_elements();
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    works_[body] = {.is_known = has_known_energy(body)};
    if (works_[body].is_known) works_[body].energy = energy_of_body(body);
  });
}

/// Adds what a contact gives to its two bodies at most: to each, the work of the force as far as the other
/// body moves, and the energy that the contact had stored. The potential of a contact is convex, so that is
/// at least the force at the end of the step times the way that it goes, and for a linear law the mean force.
void Dynamics::add_work(const Coupling& contact, const Vec3& force) {
  if (force == Vec3{}) return;
  const Index first = at(body_of_point_, contact.points[0]);
  Index second = first;
  std::array<Vec3, 2> ways{};
  for (std::size_t i = 0; i < contact.points.size(); ++i) {
    const Index p = contact.points[i];
    if (p < 0) continue;
    const bool is_first = at(body_of_point_, p) == first;
    if (!is_first) second = at(body_of_point_, p);
    ways[is_first ? 0 : 1] += contact.coefficients[i] * (at(positions_, p) - at(end_positions_, p));
  }
  const Vec3 way = ways[0] + ways[1];
  const double at_end = dot(force, way);
  const bool pushed = dot(force, contact.force) > 0.0;  // from the start of the step on
  const double stored = std::max({0.0, at_end, pushed ? 0.5 * (at_end + dot(contact.force, way)) : 0.0});
  at(works_, first).given += stored;
  at(works_, first).is_touched = true;
  if (second == first) return;
  at(works_, first).given -= dot(force, ways[1]);
  at(works_, second).given += stored - dot(force, ways[0]);
  at(works_, second).is_touched = true;
  if (at(turning_bodies_, first) != 0 && at(turning_bodies_, second) != 0)
    at(works_, first).is_known = at(works_, second).is_known = false;
}

/// Contacts of a body in a rotated frame may drive it: they act at the end of the step, on points that have
/// passed the lowest place and rise, and at arms that the step changes. Of a body whose energy has grown
/// without a reason, the rotation is slowed down so far that it has not. Errors of single steps have both
/// signs, so what contacts took in the last steps may come back.
///
/// Call at the end of a step, when end_positions_ are those of its start.
void Dynamics::limit_energies(const Joints& joints) {
  constexpr double remembered = 0.9;  // of a loss, after a step
  constexpr double none = 1e-300;
  for (double& loss : contact_losses_) loss = loss > none ? remembered * loss : 0.0;
  if (!rotations_.any()) return;
  for (std::size_t k = joints.lasting; k < joints.couplings.size(); ++k)
    add_work(joints.couplings[k], joints.forces[k]);
  for (const std::span<const Coupling> drives : {joints.couplings.first(joints.lasting), joints.driving}) {
    for (const Coupling& drive : drives) {
      for (const Index p : drive.points)
        if (p >= 0) at(works_, at(body_of_point_, p)).is_known = false;
    }
  }
  const auto is_limited = [&](std::size_t body) {
    return works_[body].is_known && works_[body].is_touched && rotations_.has_frame(static_cast<Index>(body));
  };
  bool any = false;
  for (std::size_t body = 0; body < bodies_.size(); ++body) any = any || is_limited(body);
  if (!any) return;
  update_elements();
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    if (is_limited(body)) limit_energy(body);
  });
}

void Dynamics::limit_energy(std::size_t body) {
  const Range points = bodies_[body].points;
  double given = works_[body].given;
  for (Index i = points.begin; i < points.end; ++i)
    given += dot(at(loads_, i), at(positions_, i) - at(end_positions_, i));
  const double gained = energy_of_body(body) - works_[body].energy - given - contact_losses_[body];
  contact_losses_[body] = std::max(0.0, -gained);
  if (!(gained > 0.0)) return;
  const RigidMotion motion = rigid_motion(points, masses_, positions_, velocities_);
  const Vec3 angular_velocity = motion.angular_velocity();
  const double energy = 0.5 * dot(motion.momentum, angular_velocity);
  if (!(energy > 0.0)) return;
  const double kept = std::sqrt(std::max(0.0, 1.0 - gained / energy));
  for (Index i = points.begin; i < points.end; ++i)
    at(velocities_, i) -= (1.0 - kept) * cross(angular_velocity, at(positions_, i) - motion.center);
}

}  // namespace palpate::fem
