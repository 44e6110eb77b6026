#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/matrix.hpp"
#include "geometry/rotation.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// The rigid motion that has the momenta of a body.
struct RigidMotion {
  Vec3 center{};      ///< centre of mass, m
  Vec3 velocity{};    ///< of the centre, m/s
  Vec3 momentum{};    ///< angular, about the centre
  Matrix3 inertia{};  ///< about the centre
  Matrix3 inverse_inertia{};
  double energy = 0.0;        ///< kinetic, of the motion about the centre, J
  double whole_energy = 0.0;  ///< kinetic, J
  [[nodiscard]] Vec3 angular_velocity() const { return inverse_inertia * momentum; }
  /// Whether rotation is most of the motion about the centre; false for a collapsed body.
  [[nodiscard]] bool dominates() const { return dot(momentum, angular_velocity()) > energy; }
};

/// Rotations of whole bodies within a step, so that a step can be solved in frames that rotate with them.
///
/// A step linearised about its start moves points along straight lines. So a body that rotates by an angle a
/// becomes larger by 1 - cos(a) across its axis. Linear elasticity at the start has no energy for that, but
/// the next step finds it as strain. In a stiff body that strain holds more energy than its motion had. In a
/// frame that rotates by Q about the body's centre of mass c, the step starts from the rotated body x' = c +
/// Q (x - c) and the rotated velocities Q (v - v_c), with the centrifugal force as one of the forces. So a
/// rigid rotation is exact, and keeps size, energy and angular momentum. Small rotations have no frame, since
/// a rotated frame costs a pass over all elements.
///
/// For a rotation beyond that of the frame the paths are bent: points move by that angle along arcs in place
/// of straight lines, and their velocities rotate with them. In a linear step this is no strain, so elastic
/// forces do not change. Contacts have an error of up to half the square of the angle, over the body's size.
/// So only larger angles need another frame and another solve.
class BodyRotations {
 public:
  /// \param masses     of points (n_points), kg
  /// \param obstacles  per body, 1 if it never gets a rotated frame
  ///
  /// O(n_points + n_tets).
  BodyRotations(const Bodies& bodies, const Materials& materials, std::span<const double> masses,
                std::span<const std::uint8_t> obstacles);

  /// Rotates the frames of bodies by their motion at the start of a step, with the midpoint rule for a rigid
  /// body without torque. Only bodies whose motion is mostly a rotation and whose expansion would have more
  /// than 1e-3 of their kinetic energy: blocks that rock a little in a pile do not need it. O(n_points).
  /// \param positions, velocities  (n_points x 3) at the start
  void begin(const parallel::Threads& threads, std::span<const Vec3> positions,
             std::span<const Vec3> velocities, double time_step);
  /// Rotates frames as a solution with these `velocities` rotates the bodies in this step, if the rotation
  /// beyond the frame is too large for bending. Returns whether any frame has changed. O(n_points).
  ///
  /// Contacts rotate a body, and its rotation changes the contacts: solutions and frames are a fixed-point
  /// iteration, with a step length for each body (Irons & Tuck, Int. J. Numer. Methods Eng. 1 (1969), 275).
  bool follow(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<const Vec3> velocities);
  /// Whether any body is rotated.
  [[nodiscard]] bool any() const;
  /// Bends the straight paths of a solution with these `velocities` where they would swell a body. Returns
  /// whether any is bent. O(n_points).
  /// \param held  per body, 1 if its points do not move freely: it is not bent
  bool bend(const parallel::Threads& threads, std::span<const Vec3> positions,
            std::span<const Vec3> velocities, std::span<const std::uint8_t> held);
  /// From the end of the straight path of a point to that of its arc, m.
  [[nodiscard]] Vec3 arc(Index body, const Vec3& position) const;
  /// The velocity of a point at the end of its arc.
  /// \param velocity  at the end of the straight path
  [[nodiscard]] Vec3 bent_velocity(Index body, const Vec3& position, const Vec3& velocity) const;

  /// Displacement of a point by its frame at the start of the step, x' - x, m.
  [[nodiscard]] Vec3 displacement(Index body, const Vec3& position) const;
  /// Mean velocity of a point over the step if only inertia acts on it.
  [[nodiscard]] Vec3 free_velocity(Index body, const Vec3& position, const Vec3& velocity) const;
  /// Acceleration of a point by inertia in its rotated frame, m/s^2: centrifugal, and minus the angular
  /// acceleration of the frame.
  [[nodiscard]] Vec3 inertial_acceleration(Index body, const Vec3& position) const;
  /// The mean velocity over the step minus the velocity at its end.
  [[nodiscard]] Vec3 excess_velocity(Index body, const Vec3& position) const;

 private:
  /// A body at the start of the step, and the rotation of its frame.
  struct Frame {
    Vec3 center{};
    Vec3 velocity{};
    Vec3 angle{};  ///< along the axis, rad
    Vec3 left{};   ///< angle of the last solution beyond that of its frame, rad; zero before the first
    double step_length = 1.0;     ///< fraction of `left` that was added to the frame's angle
    Quaternion rotation{};        ///< rotation by the angle: Q
    Vec3 angular_velocity{};      ///< at the end
    Vec3 angular_acceleration{};  ///< at the end, of a rigid body without torque: Euler's equations
    Vec3 correction{};  ///< angular velocity that restores the angular momentum, which Q rotates too
  };
  /// A body whose points move along arcs, from their positions in the rotated frame.
  struct Bend {
    Vec3 angle{};           ///< along the axis, rad; zero: not bent
    Quaternion rotation{};  ///< rotation by the angle
    Vec3 velocity{};        ///< of the centre, mean of the step
    Vec3 correction{};      ///< angular velocity that keeps the angular momentum
  };
  [[nodiscard]] Bend bend_of(std::size_t body, std::span<const Vec3> positions,
                             std::span<const Vec3> velocities) const;
  [[nodiscard]] RigidMotion rigid_motion(std::size_t body, std::span<const Vec3> positions,
                                         std::span<const Vec3> velocities) const;
  [[nodiscard]] Vec3 angle_of(std::size_t body, const RigidMotion& mean, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities) const;
  [[nodiscard]] bool swells(std::size_t body, const Vec3& angle, double energy) const;
  void set_frame(std::size_t body, const Vec3& angle, const Vec3& momentum);

  std::vector<Body> bodies_;
  std::vector<double> masses_;
  std::vector<double> stretch_energies_;  ///< (n_bodies) energy scale, strain 1: Young's modulus x volume, J
  std::vector<Frame> frames_;
  std::vector<Bend> bends_;
  std::vector<RigidMotion> starts_;
  std::vector<std::uint8_t> changed_;
  double time_step_ = 0.0;
};

}  // namespace palpate::fem
