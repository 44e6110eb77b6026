#include <algorithm>
#include <array>

#include "fem/dynamics.hpp"
#include "fem/padded_vectors.hpp"

// What holds the points that are not free, or not along all axes.
namespace palpate::fem {
namespace {

/// K'_e v of a corner: with a_i of Elements::gradient(), r = lambda / mu and G = sum_j v_j a_j^T it is
/// r tr(G) a_i + (G + G^T) a_i.
struct StiffForces {
  std::array<Vec3, 4> gradients;
  Matrix3 g;
  double ratio;

  [[nodiscard]] Vec3 at_corner(std::size_t i) const {
    const Vec3& a = gradients[i];
    const double trace = g(0, 0) + g(1, 1) + g(2, 2);
    const Vec3 transposed{g(0, 0) * a.x + g(1, 0) * a.y + g(2, 0) * a.z,
                          g(0, 1) * a.x + g(1, 1) * a.y + g(2, 1) * a.z,
                          g(0, 2) * a.x + g(1, 2) * a.y + g(2, 2) * a.z};
    return (ratio * trace) * a + g * a + transposed;
  }
};

}  // namespace

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

/// The matrix has h (b + h) K', of the way from the positions that the forces are of.
void Dynamics::add_stiff_forces(std::span<Vec3> forces) const {
  const bool turned = turns_.any();
  for (const Index e : held_elements_) {
    const Tet& corners = at(elements_.corners(), e);
    StiffForces stiff{.gradients = {}, .g = {}, .ratio = at(elements_.ratios(), e)};
    for (std::size_t k = 0; k < 4; ++k) {
      stiff.gradients[k] = elements_.gradient(e, static_cast<int>(k));
      Vec3 velocity = at(mean_velocities_, corners[k]);
      if (turned) velocity -= unpadded(at(turn_velocities_, corners[k]));
      add_outer(stiff.g, 1.0, velocity, stiff.gradients[k]);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      if (at(held_axes_, corners[k]) != 0) at(forces, corners[k]) += (1.0 / time_step_) * stiff.at_corner(k);
    }
  }
}

}  // namespace palpate::fem
