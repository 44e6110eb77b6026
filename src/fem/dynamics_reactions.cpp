#include <algorithm>
#include <array>

#include "fem/dynamics.hpp"
#include "fem/padded_vectors.hpp"

// Forces that hold the points that are not free, or not free along all axes.
namespace palpate::fem {

void Dynamics::find_constrained_elements() {
  constrained_elements_.clear();
  held_domains_.clear();
  const auto held = [&](std::span<const Index> points) {
    return std::ranges::any_of(points, [&](Index p) { return at(held_axes_, p) != 0; });
  };
  for (Index e = 0; e < elements_.size(); ++e) {
    if (held(at(elements_.corners(), e))) constrained_elements_.push_back(e);
  }
  for (std::size_t d = 0; d < elements_.smoothing().size(); ++d) {
    if (held(elements_.smoothing().points(d))) held_domains_.push_back(d);
  }
}

void Dynamics::holding_forces(const Vec3& gravity, std::span<const Vec3> external_forces,
                              std::span<Vec3> forces) const {
  const auto elastic = elements_.point_forces();
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    forces[i] = {};
    if (held_axes_[i] == 0) continue;
    const Vec3 acceleration = (1.0 / time_step_) * (mean_velocities_[i] - velocities_[i]);
    forces[i] = masses_[i] * (acceleration - gravity) - unpadded(elastic[i]);
    if (!external_forces.empty()) forces[i] -= external_forces[i];
  }
  add_damping_forces(forces);
  add_stiff_forces(forces);
  for (std::size_t i = 0; i < masses_.size(); ++i) forces[i] = along(held_axes_[i], forces[i]);
}

/// Adds mass damping, at points of deformable bodies.
void Dynamics::add_damping_forces(std::span<Vec3> forces) const {
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    if (held_axes_[i] != 0 && at(rigid_, body_of_point_[i]) == 0)
      forces[i] += (masses_[i] * point_mass_damping_[i]) * mean_velocities_[i];
  }
}

/// The velocity that h (b + h) K' is multiplied by. Its elastic part acts on the displacement from the
/// linearisation positions, its damping part on the motion beyond the rotation of the frame.
/// \param elastic  fraction of the factor
Vec3 Dynamics::stiff_velocity(Index point, double elastic) const {
  const auto p = static_cast<std::size_t>(point);
  Vec3 velocity = mean_velocities_[p];
  if (!rotations_.any() && !refined_) return velocity;
  velocity -= (elastic / time_step_) * (linear_positions_[p] - positions_[p]);
  velocity -= ((1.0 - elastic) / time_step_) * rotations_.displacement(body_of_point_[p], positions_[p]);
  return velocity;
}

void Dynamics::add_stiff_forces(std::span<Vec3> forces) const {
  const auto add = [&](Index point, const Vec3& stiff) {
    if (at(held_axes_, point) != 0) at(forces, point) += (1.0 / time_step_) * stiff;
  };
  for (const Index e : constrained_elements_) {
    const Tet& corners = at(elements_.corners(), e);
    std::array<Vec3, 4> velocities;
    for (std::size_t k = 0; k < 4; ++k) velocities[k] = stiff_velocity(corners[k], at(elastic_fractions_, e));
    const std::array<Vec3, 4> stiff = elements_.multiply(e, velocities);
    for (std::size_t k = 0; k < 4; ++k) add(corners[k], stiff[k]);
  }
  const SmoothingDomains& smoothing = elements_.smoothing();
  for (const std::size_t d : held_domains_) {
    const auto points = smoothing.points(d);
    const double elastic = at(elastic_fractions_, smoothing.element(d));
    smoothing.multiply(
        d, [&](std::size_t k) { return stiff_velocity(points[k], elastic); },
        [&](std::size_t k, const Vec3& stiff) { add(points[k], stiff); });
  }
}

}  // namespace palpate::fem
