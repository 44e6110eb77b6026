// The linear system of a step: matrix, forces and right side.
#include <cmath>
#include <limits>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"

namespace palpate::fem {

/// Makes B = (1 + h a) M + (h b + h^2) K', with the damping a and b of the tets, and the forces. Both are at
/// the positions at the start of the step, or at those of place_linear_positions().
void Dynamics::linearise() {
  reuses_directions_ = false;
  at_end_ = false;
  set_base_velocities();
  const bool holds_damping = elements_.has_jumps() && has_stiffness_damping_ && !refined_;
  if (holds_damping) {
    elements_.release_damping();
    updated_ = false;
  }
  if (rotations_.any() || refined_ || second_order_) {
    place_linear_positions();
    refined_ = refined_ || second_order_;
    elements_.update(threads_, linear_positions_);
    updated_ = false;
  } else {
    update_elements();
  }
  if (holds_damping) elements_.hold_damping();
  form_system();
}

/// Makes the matrix and the right side from the current elements.
void Dynamics::form_system() {
  matrix_.assemble(threads_, diagonal_);
  compute_point_forces();
  if (refined_) {
    add_displacement_forces();
  } else if (rotations_.any()) {
    add_rotation_forces();
  }
  if (has_stiffness_damping_) add_damping_of_rotation();
  if (has_stiffness_damping_ && !second_order_) remove_damping_torque();
  compute_free_right_side();
}

/// Updates the elements, unless the computation of the energy has already done so.
void Dynamics::update_elements() {
  if (!updated_) elements_.update(threads_, positions_);
  updated_ = true;
}

void Dynamics::compute_point_forces() {
  const auto elastic = elements_.point_forces();
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] != 0) point_forces_[i] = loads_[i] + unpadded(elastic[i]);
  });
}

/// Sets gravity and external forces, and their norms.
void Dynamics::set_loads(const Vec3& gravity, std::span<const Vec3> external_forces) {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    loads_[i] = masses_[i] * gravity;
    if (!external_forces.empty()) loads_[i] += external_forces[i];
  });
  // Norms of the impulse of gravity and loads in a step, and (by mass) of the velocity change that they alone
  // would cause. At rest all forces cancel, so only these give a scale for errors. Changes that
  // are far smaller than the velocities do not matter.
  load_impulse_ =
      time_step_ * std::sqrt(parallel::sum(threads_, masses_.size(), partial_,
                                           [&](std::size_t i) { return squared_length(loads_[i]); }));
  load_scale_ = time_step_ * std::sqrt(parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
                  const double load = squared_length(loads_[i]);
                  return load == 0.0 ? 0.0 : load / diagonal_[i];
                }));
  constexpr double negligible = 1e-6;
  const double of_velocities =
      negligible * std::sqrt(parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
        return masses_[i] * squared_length(velocities_[i]);
      }));
  // In a very long step, the loads alone would move everything far away, so they give no scale: the motion of
  // a few edges does.
  constexpr double few_edges = 10.0;
  error_scale_ = std::max(std::min(load_scale_, few_edges * edge_by_mass_ / time_step_), of_velocities);
  load_scale_ = std::max(load_scale_, of_velocities);
  // Without loads nothing gives a scale when bodies come to rest. But what is below the rounding errors of
  // positions is no error.
  constexpr double roundings = 100.0;
  const double extent = std::sqrt(parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return system_.free()[i] == 0 ? 0.0 : masses_[i] * squared_length(positions_[i]);
  }));
  rounding_ = roundings * std::numeric_limits<double>::epsilon() * extent / time_step_;
  // They change the forces of tissue, by more the stiffer it is.
  if (elements_.nonlinear_begin() == elements_.size()) return;
  constexpr double of_forces = 4.0;
  const double forces = parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    if (system_.free()[i] == 0 || !is_nonlinear(i)) return 0.0;
    return squared_length(nonlinear_stiffness_[i] * positions_[i]) / diagonal_[i];
  });
  tissue_rounding_ = of_forces * std::numeric_limits<double>::epsilon() * time_step_ * std::sqrt(forces);
}

/// The right side without couplings, b = h f - (h C + h^2 K') v = h f + M v - B v, by a product with the
/// current matrix B. At points that are not free v is the prescribed velocity, so their columns act on the
/// free rows. In rotated frames v is the mean velocity without forces.
void Dynamics::compute_free_right_side() {
  system_.multiply_blocks_exactly(threads_, base_velocities_, free_right_side_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    free_right_side_[i] = padded(time_step_ * point_forces_[i] + masses_[i] * unpadded(base_velocities_[i]) -
                                 unpadded(free_right_side_[i]));
  });
}

/// Adds the couplings' part, h f - W v, to the right side.
void Dynamics::compute_right_side() {
  couplings_.multiply(threads_, base_velocities_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    right_side_[i] = free_right_side_[i];
    const auto point = static_cast<Index>(i);
    if (system_.free()[i] == 0 || !couplings_.holds(point)) return;
    right_side_[i] = padded(unpadded(free_right_side_[i]) + time_step_ * couplings_.start_force(point) -
                            couplings_.product(point));
  });
  holds_.hold(time_step_, base_velocities_, right_side_);
}

}  // namespace palpate::fem
