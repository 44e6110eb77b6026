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
    works_[body] = {.group = static_cast<Index>(body), .is_known = has_known_energy(body)};
    if (works_[body].is_known) works_[body].energy = energy_of_body(body);
  });
}

/// The first body of the group of a free body.
Index Dynamics::group_of(Index body) const {
  while (at(works_, body).group != body) body = at(works_, body).group;
  return body;
}

/// Adds what a contact gives to free bodies at most: the work of its force as far as a body that is not free
/// moves, and the energy that the contact had stored. The potential of a contact is convex, so that is at
/// least the force at the end of the step times its path, and for a linear law the mean force.
void Dynamics::add_work(const Coupling& contact, const Vec3& force) {
  if (force == Vec3{}) return;
  const Index first = at(body_of_point_, contact.points[0]);
  Index second = first;
  std::array<Vec3, 2> paths{};
  for (std::size_t i = 0; i < contact.points.size(); ++i) {
    const Index p = contact.points[i];
    if (p < 0) continue;
    const bool is_first = at(body_of_point_, p) == first;
    if (!is_first) second = at(body_of_point_, p);
    paths[is_first ? 0 : 1] += contact.coefficients[i] * (at(positions_, p) - at(end_positions_, p));
  }
  const std::array<bool, 2> free{at(turning_bodies_, first) != 0, at(turning_bodies_, second) != 0};
  if (!free[0] && !free[1]) return;
  const Vec3 path = paths[0] + paths[1];
  const double at_end = dot(force, path);
  const bool pushed = dot(force, contact.force) > 0.0;  // from the start of the step on
  BodyWork& work = at(works_, free[0] ? first : second);
  work.given += std::max({0.0, at_end, pushed ? 0.5 * (at_end + dot(contact.force, path)) : 0.0});
  if (free[0] && free[1]) {
    const Index a = group_of(first);
    const Index b = group_of(second);
    at(works_, std::max(a, b)).group = std::min(a, b);
  } else {
    work.given -= dot(force, paths[free[0] ? 1 : 0]);
    work.is_supported = true;
  }
}

/// Contacts of a body in a rotated frame may drive it: they act at the end of the step, on points that have
/// passed the lowest place and rise, and at arms that the step changes. Where the energy of free bodies that
/// touch each other has grown without a reason, their rotations are slowed down so far that it has not.
/// Errors of single steps have both signs, so what contacts took in the last steps may come back.
///
/// Only of bodies that touch, maybe by others, a body that is not free: without that, their angular momentum
/// stays.
///
/// Call at the end of a step, when end_positions_ are those of its start.
void Dynamics::limit_energies(const Joints& joints) {
  constexpr double kept = 0.9;  // of a loss, after a step
  constexpr double none = 1e-300;
  for (double& loss : contact_losses_) loss = loss > none ? kept * loss : 0.0;
  if (!rotations_.any()) return;
  for (std::size_t k = joints.lasting; k < joints.couplings.size(); ++k)
    add_work(joints.couplings[k], joints.forces[k]);
  for (const std::span<const Coupling> drives : {joints.couplings.first(joints.lasting), joints.driving}) {
    for (const Coupling& drive : drives) {
      for (const Index p : drive.points)
        if (p >= 0) at(works_, at(body_of_point_, p)).is_known = false;
    }
  }
  group_bodies();
  if (std::ranges::none_of(groups_, &BodyGroup::is_limited)) return;
  update_elements();
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    if (group_with(body).is_limited()) find_gain(body);
  });
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    BodyGroup& group = group_with(body);
    group.gained += works_[body].gained - contact_losses_[body];
    group.rotation += works_[body].rotation;
  }
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    const BodyGroup& group = group_with(body);
    if (!group.is_limited()) return;
    contact_losses_[body] = std::max(0.0, -group.gained / static_cast<double>(group.bodies));
    if (group.gained > 0.0 && works_[body].rotation > 0.0)
      slow_down(body, std::sqrt(std::max(0.0, 1.0 - group.gained / group.rotation)));
  });
}

/// Finds the groups of free bodies that touch each other.
void Dynamics::group_bodies() {
  groups_.assign(bodies_.size(), {});
  for (Index body = 0; body < std::ssize(bodies_); ++body) {
    BodyWork& work = at(works_, body);
    work.group = group_of(body);
    BodyGroup& group = at(groups_, work.group);
    ++group.bodies;
    group.is_known = group.is_known && work.is_known;
    group.is_supported = group.is_supported || work.is_supported;
    group.rotates = group.rotates || rotations_.has_frame(body);
  }
}

/// Finds how far the energy of a body has grown beyond what it was given, and the energy of its rotation if
/// it has a frame.
void Dynamics::find_gain(std::size_t body) {
  const Range points = bodies_[body].points;
  BodyWork& work = works_[body];
  double given = work.given;
  for (Index i = points.begin; i < points.end; ++i)
    given += dot(at(loads_, i), at(positions_, i) - at(end_positions_, i));
  work.gained = energy_of_body(body) - work.energy - given;
  if (!rotations_.has_frame(static_cast<Index>(body))) return;
  const RigidMotion motion = rigid_motion(points, masses_, positions_, velocities_);
  const double energy = 0.5 * dot(motion.momentum, motion.angular_velocity());
  work.rotation = energy > 0.0 ? energy : 0.0;
}

/// Multiplies the angular velocity of a body.
void Dynamics::slow_down(std::size_t body, double factor) {
  const Range points = bodies_[body].points;
  const RigidMotion motion = rigid_motion(points, masses_, positions_, velocities_);
  const Vec3 less = (1.0 - factor) * motion.angular_velocity();
  for (Index i = points.begin; i < points.end; ++i)
    at(velocities_, i) -= cross(less, at(positions_, i) - motion.center);
}

}  // namespace palpate::fem
