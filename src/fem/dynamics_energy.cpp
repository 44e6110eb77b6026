// Energies of a Dynamics.
#include <algorithm>
#include <optional>

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

/// Elastic and kinetic energy of a free body and that of an ambient pressure, J. O(elements and points of the
/// body).
double Dynamics::energy_of_body(std::size_t body) const {
  double energy = 0.0;
  for (const Index e : elements_of_body_[static_cast<Index>(body)]) {
    const bool is_viscous = elements_.viscosity().has(static_cast<std::size_t>(e));
    energy += is_viscous ? elements_.energy(e, positions_) + elements_.ambient_energy(e, positions_)
                         : elements_.energy(e);
  }
  const Range points = bodies_[body].points;
  for (Index i = points.begin; i < points.end; ++i)
    energy += 0.5 * at(masses_, i) * squared_length(at(velocities_, i));
  return energy;
}

/// Whether all that changes the energy of a body in a step is known, but for what contacts do: it is free, no
/// force turns with it, and its energy is that of its elements.
bool Dynamics::has_known_energy(std::size_t body) const {
  if (turning_bodies_[body] == 0) return false;
  if (elements_.smoothing().is_viscous() &&
      std::ranges::any_of(elements_of_body_[static_cast<Index>(body)],
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
    energy_limit_.begin(body, has_known_energy(body) ? std::optional(energy_of_body(body)) : std::nullopt);
  });
}

/// Adds a contact to the energies. Call when end_positions_ are those of the start of the step.
void Dynamics::add_energy(const Coupling& contact, const Vec3& force) {
  if (force == Vec3{}) return;
  const Index first = at(body_of_point_, contact.points[0]);
  EnergyLimit::Contact added{
      .bodies = {first, first}, .free{}, .paths{}, .force = force, .force_at_start = contact.force};
  for (std::size_t i = 0; i < contact.points.size(); ++i) {
    const Index p = contact.points[i];
    if (p < 0) continue;
    const bool is_first = at(body_of_point_, p) == first;
    if (!is_first) added.bodies[1] = at(body_of_point_, p);
    added.paths[is_first ? 0 : 1] += contact.coefficients[i] * (at(positions_, p) - at(end_positions_, p));
  }
  for (std::size_t i = 0; i < 2; ++i) added.free[i] = at(turning_bodies_, added.bodies[i]) != 0;
  energy_limit_.add(added);
}

/// Slows down the rotations that contacts drive (EnergyLimit). Call at the end of a step, when end_positions_
/// are those of its start.
void Dynamics::limit_energies(const Joints& joints) {
  energy_limit_.forget();
  if (!rotations_.any()) return;
  for (std::size_t k = joints.lasting; k < joints.couplings.size(); ++k)
    add_energy(joints.couplings[k], joints.forces[k]);
  for (const std::span<const Coupling> drives : {joints.couplings.first(joints.lasting), joints.driving}) {
    for (const Coupling& drive : drives) {
      for (const Index p : drive.points)
        if (p >= 0) energy_limit_.mark_unknown(at(body_of_point_, p));
    }
  }
  for (Index body = 0; body < std::ssize(bodies_); ++body)
    if (rotations_.has_frame(body)) energy_limit_.mark_rotating(body);
  if (!energy_limit_.find_groups()) return;
  update_elements();
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    if (energy_limit_.is_limited(body)) end_energy(body);
  });
  energy_limit_.settle();
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    if (const double factor = energy_limit_.factor(body); factor < 1.0) slow_down(body, factor);
  });
}

/// Passes the energies of a body at the end of the step.
void Dynamics::end_energy(std::size_t body) {
  const Range points = bodies_[body].points;
  double given = energy_limit_.given(body);
  for (Index i = points.begin; i < points.end; ++i)
    given += dot(at(loads_, i), at(positions_, i) - at(end_positions_, i));
  double rotation = 0.0;
  if (rotations_.has_frame(static_cast<Index>(body))) {
    const RigidMotion motion = rigid_motion(points, masses_, positions_, velocities_);
    rotation = std::max(0.0, 0.5 * dot(motion.momentum, motion.angular_velocity()));
  }
  energy_limit_.set_end(body, energy_of_body(body), given, rotation);
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
