#include <algorithm>
#include <array>

#include "fem/dynamics.hpp"
#include "fem/padded_vectors.hpp"

// What holds the points that are not free, or not along all axes.
namespace palpate::fem {

void Dynamics::find_held_elements() {
  held_elements_.clear();
  for (Index e = 0; e < elements_.size(); ++e) {
    const Tet& corners = at(elements_.corners(), e);
    if (std::ranges::any_of(corners, [&](Index p) { return at(held_axes_, p) != 0; }))
      held_elements_.push_back(e);
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

/// Damping by mass acts where there is tissue.
void Dynamics::add_damping_forces(std::span<Vec3> forces) const {
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    if (held_axes_[i] != 0 && at(rigid_, body_of_point_[i]) == 0)
      forces[i] += (masses_[i] * point_mass_damping_[i]) * mean_velocities_[i];
  }
}

/// The matrix has h (b + h) K'. Its elastic part is of the way from the positions that the forces are of,
/// that of damping of what a body moves besides its turn.
void Dynamics::add_stiff_forces(std::span<Vec3> forces) const {
  const bool placed = turns_.any() || refined_;
  for (const Index e : held_elements_) {
    const Tet& corners = at(elements_.corners(), e);
    const double elastic = at(elastic_fractions_, e);
    std::array<Vec3, 4> velocities{};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto p = static_cast<std::size_t>(corners[k]);
      velocities[k] = mean_velocities_[p];
      if (!placed) continue;
      velocities[k] -= (elastic / time_step_) * (linear_positions_[p] - positions_[p]);
      velocities[k] -= ((1.0 - elastic) / time_step_) * turns_.displacement(body_of_point_[p], positions_[p]);
    }
    const std::array<Vec3, 4> stiff = elements_.multiply(e, velocities);
    for (std::size_t k = 0; k < 4; ++k) {
      if (at(held_axes_, corners[k]) != 0) at(forces, corners[k]) += (1.0 / time_step_) * stiff[k];
    }
  }
}

}  // namespace palpate::fem
