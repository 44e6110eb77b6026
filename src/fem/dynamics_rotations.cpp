// Rotating frames of bodies in a step.
#include <algorithm>

#include "fem/dynamics.hpp"
#include "fem/grains.hpp"
#include "fem/padded_vectors.hpp"

namespace palpate::fem {

/// Marks the free bodies, and the bodies that get no arcs: nonlinear ones, and bodies that are not free.
void Dynamics::mark_held_bodies() {
  held_bodies_.assign(bodies_.size(), 0);
  free_bodies_.assign(bodies_.size(), 1);
  for (std::size_t body = 0; body < bodies_.size(); ++body)
    if (braked_bodies_[body] != 0) free_bodies_[body] = 2;
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    const Index body = body_of_point_[i];
    if (held_axes_[i] != 0) at(free_bodies_, body) = 0;
    if (held_axes_[i] != 0 || is_nonlinear(i)) at(held_bodies_, body) = 1;
  }
}

/// Sets the velocities to which the solution is added. A change of frames changes them, so the solution is
/// adapted.
void Dynamics::set_base_velocities() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) {
      base_velocities_[i] = {};
      return;
    }
    const Vec3 velocity = rotations_.free_velocity(body_of_point_[i], positions_[i], velocities_[i]);
    solution_[i] = padded(unpadded(solution_[i]) + unpadded(base_velocities_[i]) - velocity);
    base_velocities_[i] = padded(velocity);
  });
  for (std::size_t k = 0; k < prescribed_points_.size(); ++k) {
    const Index i = prescribed_points_[k];
    at(base_velocities_, i) = padded((1.0 / time_step_) * (prescribed_positions_[k] - at(positions_, i)));
  }
}

/// Rotates the frames of bodies by their motion at the start of the step.
void Dynamics::begin_rotations(double time_step) {
  if (second_order_) return;
  turning_bodies_ = free_bodies_;
  for (const Index p : prescribed_points_) at(turning_bodies_, at(body_of_point_, p)) = 0;
  rotations_.begin(threads_, positions_, velocities_, time_step, turning_bodies_);
}

std::span<const Vec3> Dynamics::excess_velocities() {
  excess_velocities_.resize(masses_.size());
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    excess_velocities_[i] =
        system_.free()[i] != 0 ? rotations_.excess_velocity(body_of_point_[i], positions_[i]) : Vec3{};
  });
  return excess_velocities_;
}

std::span<const Vec3> Dynamics::deformed_positions(double time_step) {
  constexpr double ahead = 0.75;  // half drives vibrations; with all, stiff bodies tremble
  const double h = step_length(time_step);
  begin_rotations(h);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Index body = body_of_point_[i];
    end_positions_[i] = positions_[i];
    if (at(braked_bodies_, body) == 0) return;
    const Vec3 turns = rotations_.has_frame(body) ? rotations_.rigid_velocity(body, positions_[i]) : Vec3{};
    end_positions_[i] += ahead * h * (velocities_[i] - turns);
  });
  return end_positions_;
}

bool Dynamics::update_rotating_frames() {
  if (second_order_ || !rotations_.follow(threads_, positions_, mean_velocities_)) return false;
  const bool rotates_directions = reuses_directions_ && !refined_ && !has_linear_couplings_;
  turn_solution();
  linearise();
  if (rotates_directions)
    contact_solver_.rotate_directions(threads_, matrix_.point_of_row(), body_of_point_, rotations_);
  reuses_directions_ = rotates_directions;
  find_end();
  return true;
}

/// Turns the solution with the frames that have changed.
void Dynamics::turn_solution() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Index body = body_of_point_[i];
    if (system_.free()[i] == 0 || !rotations_.has_rotated(body)) return;
    const Vec3 velocity = rotations_.rotated_velocity(body, positions_[i], mean_velocities_[i]);
    solution_[i] = padded(velocity - unpadded(base_velocities_[i]));
  });
}

/// Adds the terms of rotated frames to the forces: (h b + h^2) K' (x' - x) / h, since K' acts on
/// displacements from the rotated positions x'; and the inertial forces.
void Dynamics::add_rotation_forces() {
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    rotation_velocities_[i] = padded((1.0 / time_step_) * (linear_positions_[i] - positions_[i]));
  });
  system_.multiply_blocks_exactly(threads_, rotation_velocities_, right_side_);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (system_.free()[i] == 0) return;
    const Vec3 stiff = unpadded(right_side_[i]) - diagonal_[i] * unpadded(rotation_velocities_[i]);
    point_forces_[i] += (1.0 / time_step_) * stiff + frame_force(i);
  });
}

/// The inertial force of a point in a rotated frame, and what the rotation changes of the loads that turn.
Vec3 Dynamics::frame_force(std::size_t point) const {
  const Index body = body_of_point_[point];
  const Vec3 inertial = masses_[point] * rotations_.inertial_acceleration(body, positions_[point]);
  if (turning_forces_.empty()) return inertial;
  return inertial + rotations_.turned_vector(body, turning_forces_[point]) - turning_forces_[point];
}

/// Takes the rigid rotations of bodies without a frame out of the stiffness damping: in a strained body they
/// would be braked by it, since its matrix does not vanish there. Frames already leave them out.
void Dynamics::add_damping_of_rotation() {
  const double rate = 1.0 / time_step_;
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Index body = body_of_point_[i];
    const Vec3 beyond =
        rotations_.rigid_displacement(body, positions_[i]) - rotations_.displacement(body, positions_[i]);
    displacements_[i] = padded(rate * beyond);
  });
  const auto products = elements_.multiply(threads_, displacements_, StiffnessPart::damping);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    if (free_[i] != 0) point_forces_[i] += rate * unpadded(products[i]);
  });
}

/// Takes the torque out of the stiffness damping of free bodies of hyperelastic or smoothed tets, as it was
/// with the last solution, or will be if velocities change as in the last step. The derivative of the forces
/// has a part by their rotation, -f x v, so in strained tissue the damping K' v has the torque of sum f x v,
/// whatever the step: a bar that was let go from a sheared shape began to spin. Newton's method makes the
/// torque zero at its end.
void Dynamics::remove_damping_torque() {
  if (std::ranges::find(turning_bodies_, 2) == turning_bodies_.end()) return;
  const double rate = 1.0 / time_step_;
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    const Vec3 rigid = rotations_.rigid_displacement(body_of_point_[i], positions_[i]);
    Vec3 velocity = refined_ ? mean_velocities_[i] : unpadded(base_velocities_[i]);
    if (!refined_ && !rotations_.any()) velocity += velocity_changes_[i];
    displacements_[i] = padded(velocity - rate * rigid);
  });
  const std::span<const Vec3> linearised = linear_positions();
  const auto products = elements_.multiply(threads_, displacements_, StiffnessPart::damping);
  parallel::for_each(threads_, masses_.size(), point_grain, [&](std::size_t i) {
    damping_changes_[i] = masses_[i] > 0.0 ? (1.0 / masses_[i]) * unpadded(products[i]) : Vec3{};
  });
  parallel::for_each(threads_, bodies_.size(), 1, [&](std::size_t body) {
    const Range points = bodies_[body].points;
    if (turning_bodies_[body] != 2) return;
    const RigidMotion lost = rigid_motion(points, masses_, linearised, damping_changes_);
    const Vec3 rotation = lost.angular_velocity();
    if (!is_finite(rotation)) return;
    for (Index p = points.begin; p < points.end; ++p) {
      const auto i = static_cast<std::size_t>(p);
      point_forces_[i] += (rate * masses_[i]) * cross(rotation, linearised[i] - lost.center);
    }
  });
}

}  // namespace palpate::fem
