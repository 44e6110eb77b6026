#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/rigid_motion.hpp"
#include "geometry/rotation.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// Rotations of whole bodies within a step. They make it possible to solve a step in frames that rotate with
/// the bodies.
///
/// A step that is linearised at its start moves points along straight lines. So a body that rotates by an
/// angle a expands by 1 - cos(a) across its axis. Linear elasticity at the start has no energy for that, but
/// the next step finds it as strain. In a stiff body that strain can hold more energy than the motion had.
///
/// Therefore a step may be solved in a frame that rotates by Q about the body's centre of mass c. It starts
/// from the rotated body x' = c + Q (x - c) and the rotated velocities Q (v - v_c), with the centrifugal
/// force as one of the forces. Then a rigid rotation is exact: size, energy and angular momentum are kept.
/// Bodies with small rotations get no frame, since a rotated frame costs a pass over all elements.
///
/// The solution may rotate a body beyond its frame. Then points move along arcs of that further angle instead
/// of straight lines, and their velocities rotate with them. A linear step has no strain from that, so
/// elastic forces do not change. Contacts have an error of up to half the square of the angle, relative to
/// the body's size. So only larger angles need another frame and another solve.
class BodyRotations {
 public:
  /// \param masses     of points (n_points), kg
  /// \param obstacles  per body, 1 if it never gets a rotated frame
  ///
  /// O(n_points + n_tets).
  BodyRotations(const Bodies& bodies, const Materials& materials, std::span<const double> masses,
                std::span<const std::uint8_t> obstacles);

  /// Rotates the frames of bodies by their motion at the start of a step, as rigid bodies without torque. A
  /// body gets a frame only if its motion about the centre is mostly a rotation, and if one of two conditions
  /// holds: its expansion would store more than 5e-4 of the energy of that motion, or it is free, rotates by
  /// more than 1e-3 rad, and its motion neither deforms nor strains it much. Without a frame, contacts of a
  /// body that rolls brake it, in proportion to the angle; and a matrix that has the derivative of its forces
  /// by rotations takes a fraction of about the square of the angle from its energy of rotation. O(n_points).
  ///
  /// \param positions, velocities  (n_points x 3) at the start
  /// \param free                   (n_bodies) 1: no point of the body is held; 2: and its matrix has that
  ///                               derivative, so it may deform; or empty: all are held
  void begin(const parallel::Threads& threads, std::span<const Vec3> positions,
             std::span<const Vec3> velocities, double time_step, std::span<const std::uint8_t> free = {});
  /// Updates the frames after a solution with these `velocities`, where it rotates a body too far beyond its
  /// frame for arcs. Bodies that rotate by more than pi in a step keep their frames. Returns whether any
  /// frame has changed. O(n_points).
  ///
  /// Contacts rotate a body, and its rotation changes the contacts. So solutions and frames are a fixed-point
  /// iteration, with a step length for each body (Irons & Tuck, Int. J. Numer. Methods Eng. 1 (1969), 275).
  bool follow(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<const Vec3> velocities);
  /// Whether the last follow() has rotated the frame of a body.
  [[nodiscard]] bool has_rotated(Index body) const { return at(changed_, body) != 0; }
  /// The rotation from the frame before the last follow() to the frame now.
  [[nodiscard]] const Quaternion& frame_change(Index body) const { return at(changes_, body).rotation; }
  /// The mean velocity of a point of a turned body over the step, so that its deformation in the frame stays
  /// the same and its points move along arcs to the new frame.
  /// \param velocity  by the solution in the frame before
  [[nodiscard]] Vec3 rotated_velocity(Index body, const Vec3& position, const Vec3& velocity) const;
  /// Whether any body has a rotated frame.
  [[nodiscard]] bool any() const;
  /// The angle of the frame of a body, rad; 0 without a frame.
  [[nodiscard]] double angle(Index body) const { return length(at(frames_, body).angle); }
  /// The largest angle of a frame, with whole turns, rad. O(n_bodies).
  [[nodiscard]] double largest_angle() const;
  /// Chooses the bodies whose points move along arcs instead of the straight paths of a solution with these
  /// `velocities`: those that straight paths would expand. Returns whether there are any. O(n_points).
  /// \param held  per body, 1 if its points do not move freely: it gets no arcs
  bool set_arcs(const parallel::Threads& threads, std::span<const Vec3> positions,
                std::span<const Vec3> velocities, std::span<const std::uint8_t> held);
  /// Displacement from the end of a point's straight path to the end of its arc, m.
  [[nodiscard]] Vec3 arc_displacement(Index body, const Vec3& position) const;
  /// The velocity of a point at the end of its arc.
  /// \param velocity  at the end of the straight path
  [[nodiscard]] Vec3 arc_velocity(Index body, const Vec3& position, const Vec3& velocity) const;

  /// Displacement of a point by its frame at the start of the step, x' - x, m.
  [[nodiscard]] Vec3 displacement(Index body, const Vec3& position) const;
  /// Mean velocity of a point over the step if no force but inertia acts on it.
  [[nodiscard]] Vec3 free_velocity(Index body, const Vec3& position, const Vec3& velocity) const;
  /// Inertial acceleration of a point in its rotated frame, m/s^2: centrifugal, and minus the angular
  /// acceleration of the frame (Euler force).
  [[nodiscard]] Vec3 inertial_acceleration(Index body, const Vec3& position) const;
  [[nodiscard]] bool has_frame(Index body) const { return at(frames_, body).angle != Vec3{}; }
  /// Velocity of a point by the rigid rotation of its body at the start of the step, m/s; zero for bodies of
  /// points on a line and for obstacles.
  [[nodiscard]] Vec3 rigid_velocity(Index body, const Vec3& position) const;
  /// The angular momentum that a point of a rotated body lacks because forces of the step move it by
  /// `displacement` to another arm, while it keeps the velocity that the rotation gave it at the old one, for
  /// each mass, m^2/s. Where Coriolis forces are left out (large angles), so is this.
  [[nodiscard]] Vec3 lost_momentum(Index body, const Vec3& position, const Vec3& displacement) const;
  /// A vector that rotates with the frame of a body.
  [[nodiscard]] Vec3 turned_vector(Index body, const Vec3& a) const;
  /// Angular impulse about the centre that a force on a point gives if it acts at `place` at the start of the
  /// step, less that by the point's arm in the rotated frame, N m s. Zero without a frame.
  [[nodiscard]] Vec3 lost_impulse(Index body, const Vec3& position, const Vec3& place,
                                  const Vec3& force) const;
  /// What a body may get of the angular impulses that it lacks, with these `velocities` at the end of the
  /// step. They are computed from the forces of the step, so they must not feed themselves: a body that has
  /// lost half of the angular velocity of its frame, as one that is held, gets none (all from three quarters
  /// on), and no body gets more than a quarter of it, or becomes faster than its frame. `lasting` is from
  /// forces that act from the start of the step on. `contacts` counts only where it brakes the body, since
  /// impacts would gain energy. O(points of the body).
  [[nodiscard]] Vec3 allowed_impulse(Index body, const Vec3& lasting, const Vec3& contacts,
                                     std::span<const Vec3> positions, std::span<const Vec3> velocities) const;
  /// At most a quarter of the angular velocity of the frame: a collapsed body has hardly any inertia.
  [[nodiscard]] Vec3 bounded_impulse(Index body, const Vec3& impulse) const;
  /// Velocity of a point at the end of the step by an angular impulse about the centre of its body, m/s.
  [[nodiscard]] Vec3 velocity_by(Index body, const Vec3& position, const Vec3& impulse) const;
  /// Displacement of a point by the rigid rotation of its body in the step: by its frame, or, without one,
  /// along the straight path by the angular velocity at the start, m.
  [[nodiscard]] Vec3 rigid_displacement(Index body, const Vec3& position) const;
  /// The mean velocity over the step minus the velocity at its end.
  [[nodiscard]] Vec3 excess_velocity(Index body, const Vec3& position) const;

 private:
  /// A body at the start of the step, and the rotation of its frame.
  struct Frame {
    Vec3 center{};
    Vec3 velocity{};
    Vec3 angle{};  ///< rotation vector of the frame, rad
    Vec3 left{};   ///< rotation vector of the last solution beyond its frame, rad; zero before the first
                   ///< solution
    double step_length = 1.0;     ///< fraction of `left` that was added to the frame's angle
    Quaternion rotation{};        ///< Q, the rotation by `angle`
    Vec3 angular_velocity{};      ///< at the end of the step
    Vec3 angular_acceleration{};  ///< at the end of the step, of a rigid body without torque (Euler's
                                  ///< equations)
    /// Angular velocity that restores the angular momentum at the end of a step without forces: Q rotates
    /// it, and the body deforms.
    Vec3 correction{};
    /// Fraction of the Coriolis force, which turns the velocity of the deformation back against Q. 0 for
    /// large angles, where it would be far from that of the middle of the step.
    double coriolis = 0.0;
  };
  /// A change of a frame.
  struct FrameChange {
    Quaternion rotation{};  ///< from the frame before to the frame now
    Vec3 angle{};           ///< its rotation vector, rad
    Quaternion before{};    ///< rotation of the frame before
    Vec3 velocity{};        ///< mean velocity of the centre of mass over the step
  };
  /// A body whose points move along arcs, starting from their positions in the rotated frame.
  struct ArcMotion {
    Vec3 angle{};           ///< rotation vector, rad; zero: straight paths
    Quaternion rotation{};  ///< the rotation by `angle`
    Vec3 velocity{};        ///< of the centre of mass, mean over the step
    Vec3 correction{};      ///< angular velocity that keeps the angular momentum
  };
  [[nodiscard]] ArcMotion arc_motion_of(std::size_t body, std::span<const Vec3> positions,
                                        std::span<const Vec3> velocities) const;
  [[nodiscard]] RigidMotion motion_of(std::size_t body, std::span<const Vec3> positions,
                                      std::span<const Vec3> velocities) const {
    return rigid_motion(bodies_[body].points, masses_, positions, velocities);
  }
  [[nodiscard]] Vec3 angle_of(std::size_t body, const RigidMotion& mean, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities) const;
  [[nodiscard]] bool swells(std::size_t body, const Vec3& angle, double energy) const;
  [[nodiscard]] double whole_revolutions(std::size_t body) const;
  void set_frame(std::size_t body, const Vec3& angle, const Vec3& momentum);

  std::vector<Body> bodies_;
  std::vector<double> masses_;
  std::vector<double>
      stretch_energies_;  ///< (n_bodies) energy scale of a strain of 1: Young's modulus x volume, J
  std::vector<Frame> frames_;
  std::vector<ArcMotion> arcs_;
  std::vector<RigidMotion> starts_;
  std::vector<std::uint8_t> changed_;
  std::vector<FrameChange> changes_;
  double time_step_ = 0.0;
};

}  // namespace palpate::fem
