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
  Vec3 center{};      ///< of mass, m
  Vec3 velocity{};    ///< of the centre, m/s
  Vec3 momentum{};    ///< angular, about the centre
  Matrix3 inertia{};  ///< about the centre
  Matrix3 inverse_inertia{};
  double energy = 0.0;        ///< kinetic, of the motion about the centre, J
  double whole_energy = 0.0;  ///< kinetic, J
  [[nodiscard]] Vec3 angular_velocity() const { return inverse_inertia * momentum; }
  /// Whether it is most of the motion about the centre. Not so, and false, in a body that has collapsed.
  [[nodiscard]] bool dominates() const { return dot(momentum, angular_velocity()) > energy; }
};

/// Rotations of whole bodies within a step, so that a step can be solved in frames that rotate with them.
///
/// A step linearised about its start moves points along straight lines. So a body that rotates by an angle a
/// becomes larger by 1 - cos(a) across its axis. Linear elasticity at the start has no energy for that, but
/// the next step finds it as strain. In a stiff body that strain holds more energy than its motion had. In a
/// frame that turns by Q about the body's centre of mass c, the step starts from the turned body x' = c + Q
/// (x - c) and the turned velocities Q (v - v_c), and inertia against the turn (the centrifugal force) is one
/// of the forces: a rigid rotation is exact, and keeps size, energy and angular momentum. Small rotations are
/// left out, since a rotated frame costs a pass over all elements.
///
/// For a rotation beyond that of the frame the paths are bent: points move by that angle along arcs in place
/// of straight lines, and their velocities rotate with them. In a linear step this is no strain, so elastic
/// forces do not change. Contacts have an error of up to half the square of the angle, over the body's size.
/// So only larger angles need another frame and another solve.
class BodyRotations {
 public:
  /// \param masses     of points (n_points), kg
  /// \param obstacles  per body: 1 where it is never followed
  /// O(n_points + n_tets).
  BodyRotations(const Bodies& bodies, const Materials& materials, std::span<const double> masses,
                std::span<const std::uint8_t> obstacles);

  /// Rotates the frames of bodies by their motion at the start of a step, with the midpoint rule for a rigid
  /// body without torque. Only bodies whose motion is mostly a rotation, and where the expansion would hold
  /// more than 1e-3 of their kinetic energy: blocks that rock a little in a pile do not need it. O(n_points).
  /// \param positions, velocities  (n_points x 3) at the start
  void begin(const parallel::Threads& threads, std::span<const Vec3> positions,
             std::span<const Vec3> velocities, double time_step);
  /// Turns bodies as a solution does that moves the points by `velocities` in the step that has begun, where
  /// what is left of its turn is more than to be bent. Returns whether any has another turn than before.
  /// O(n_points).
  ///
  /// Where contacts turn a body, its turn changes the contacts: solutions and frames are a fixed-point
  /// iteration, with a step length for each body (Irons & Tuck, Int. J. Numer. Methods Eng. 1 (1969), 275).
  bool follow(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<const Vec3> velocities);
  /// Whether any body is rotated.
  [[nodiscard]] bool any() const;
  /// Bends the straight paths of a solution that moves the points by `velocities` beyond the frames, where
  /// they would swell a body. Returns whether any is bent. O(n_points). \param held  per body: 1 where points
  /// do not move freely, so that it is not bent
  bool bend(const parallel::Threads& threads, std::span<const Vec3> positions,
            std::span<const Vec3> velocities, std::span<const std::uint8_t> held);
  /// From the end of the straight path of a point to that of its arc, m.
  [[nodiscard]] Vec3 arc(Index body, const Vec3& position) const;
  /// The velocity of a point at the end of its arc. \param velocity  at the end of the straight path
  [[nodiscard]] Vec3 bent_velocity(Index body, const Vec3& position, const Vec3& velocity) const;

  /// Of a point at the start of the step, x' - x, m.
  [[nodiscard]] Vec3 displacement(Index body, const Vec3& position) const;
  /// Mean velocity over the step with which a point goes on if no force but inertia acts on it.
  [[nodiscard]] Vec3 free_velocity(Index body, const Vec3& position, const Vec3& velocity) const;
  /// What inertia accelerates a point by in its rotated frame, m/s^2: outwards by the centrifugal force, less
  /// what turns the body as a whole, which its frame does already.
  [[nodiscard]] Vec3 inertial_acceleration(Index body, const Vec3& position) const;
  /// The mean velocity over the step minus the velocity at its end.
  [[nodiscard]] Vec3 excess_velocity(Index body, const Vec3& position) const;

 private:
  /// A body at the start of the step, and the rotation of its frame.
  struct Frame {
    Vec3 center{};
    Vec3 velocity{};
    Vec3 angle{};                 ///< along the axis, rad
    Vec3 left{};                  ///< angle of the last solution beyond that of its frame, rad; zero: none
    double step_length = 1.0;     ///< fraction of it by which the frame was turned on
    Quaternion rotation{};        ///< by it: Q
    Vec3 angular_velocity{};      ///< at the end
    Vec3 angular_acceleration{};  ///< at the end, of a rigid body without torque: Euler's equations
    Vec3 correction{};            ///< angular velocity that keeps the angular momentum: Q turns that, too
  };
  /// A body whose points move along arcs, from their positions in the rotated frame.
  struct Bend {
    Vec3 angle{};           ///< along the axis, rad; zero: none
    Quaternion rotation{};  ///< by it
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
  std::vector<double> stretch_energies_;  ///< (n_bodies) of strain 1: Young's modulus x volume, J
  std::vector<Frame> frames_;
  std::vector<Bend> bends_;
  std::vector<RigidMotion> starts_;
  std::vector<std::uint8_t> changed_;
  double time_step_ = 0.0;
};

}  // namespace palpate::fem
