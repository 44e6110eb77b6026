#include "fem/energy_limit.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fem {

void EnergyLimit::begin(std::size_t body, std::optional<double> energy) {
  works_[body] = {
      .group = static_cast<Index>(body), .is_known = energy.has_value(), .energy = energy.value_or(0.0)};
}

void EnergyLimit::forget() {
  constexpr double kept = 0.9;  // of a loss, after a step
  constexpr double none = 1e-300;
  for (double& loss : losses_) loss = loss > none ? kept * loss : 0.0;
}

/// The first body of the group, as far as it is known.
Index EnergyLimit::first_of_group(Index body) const {
  while (at(works_, body).group != body) body = at(works_, body).group;
  return body;
}

/// Adds what a contact gives to free bodies at most: the work of its force as far as a body that is not free
/// moves, and the energy that the contact had stored. The potential of a contact is convex, so that is at
/// least the force at the end of the step times its path, and for a linear law the mean force.
void EnergyLimit::add(const Contact& contact) {
  const auto& [first, second] = contact.bodies;
  const auto& [first_free, second_free] = contact.free;
  if (!first_free && !second_free) return;
  const Vec3& force = contact.force;
  const Vec3 path = contact.paths[0] + contact.paths[1];
  const double at_end = dot(force, path);
  const bool pushed = dot(force, contact.force_at_start) > 0.0;  // from the start of the step on
  Work& work = at(works_, first_free ? first : second);
  work.given += std::max({0.0, at_end, pushed ? 0.5 * (at_end + dot(contact.force_at_start, path)) : 0.0});
  if (first_free && second_free) {
    const Index a = first_of_group(first);
    const Index b = first_of_group(second);
    at(works_, std::max(a, b)).group = std::min(a, b);
  } else {
    work.given -= dot(force, contact.paths[first_free ? 1 : 0]);
    work.is_supported = true;
  }
}

bool EnergyLimit::find_groups() {
  groups_.assign(works_.size(), {});
  for (Index body = 0; body < std::ssize(works_); ++body) {
    Work& work = at(works_, body);
    work.group = first_of_group(body);
    Group& group = at(groups_, work.group);
    ++group.bodies;
    group.is_known = group.is_known && work.is_known;
    group.is_supported = group.is_supported || work.is_supported;
    group.rotates = group.rotates || work.rotates;
  }
  return std::ranges::any_of(groups_, &Group::is_limited);
}

void EnergyLimit::set_end(std::size_t body, double energy, double given, double rotation) {
  Work& work = works_[body];
  work.gained = energy - work.energy - given;
  work.rotation = rotation;
}

void EnergyLimit::settle() {
  for (std::size_t body = 0; body < works_.size(); ++body) {
    Group& group = at(groups_, works_[body].group);
    group.gained += works_[body].gained - losses_[body];
    group.rotation += works_[body].rotation;
  }
  for (std::size_t body = 0; body < works_.size(); ++body) {
    if (is_limited(body))
      losses_[body] = std::max(0.0, -group(body).gained / static_cast<double>(group(body).bodies));
  }
}

double EnergyLimit::factor(std::size_t body) const {
  const Group& group = this->group(body);
  if (!group.is_limited() || !(group.gained > 0.0) || !(works_[body].rotation > 0.0)) return 1.0;
  return std::sqrt(std::max(0.0, 1.0 - group.gained / group.rotation));
}

}  // namespace palpate::fem
