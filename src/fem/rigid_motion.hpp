#pragma once

#include <array>
#include <span>

#include <palpate/mesh.hpp>

#include "fem/matrix.hpp"
#include "geometry/rotation.hpp"

namespace palpate::fem {

/// The rigid motion with the same linear and angular momentum as a body.
struct RigidMotion {
  Vec3 center{};      ///< centre of mass, m
  Vec3 velocity{};    ///< of the centre, m/s
  Vec3 momentum{};    ///< angular, about the centre
  Matrix3 inertia{};  ///< about the centre
  Matrix3 inverse_inertia{};
  /// Sum of m r_k d over the points for each axis k, with r from the centre and d the velocity beyond the
  /// rigid motion.
  std::array<Vec3, 3> deformation{};
  double energy = 0.0;  ///< kinetic, of the motion about the centre, J
  [[nodiscard]] Vec3 angular_velocity() const { return inverse_inertia * momentum; }
  /// Whether rotation is more than half of the motion about the centre; false for a collapsed body.
  [[nodiscard]] bool dominates() const { return dot(momentum, angular_velocity()) > energy; }
  /// Whether rotation is more than nine tenths of the motion about the centre.
  [[nodiscard]] bool is_rigid() const { return dot(momentum, angular_velocity()) > 1.8 * energy; }
};

/// \param points  of the body
/// \param masses, positions, velocities  of all points
///
/// O(points of the body).
[[nodiscard]] RigidMotion rigid_motion(Range points, std::span<const double> masses,
                                       std::span<const Vec3> positions, std::span<const Vec3> velocities);

/// The rotation vector of a rigid body without torque over a step. A body with the middle principal moment of
/// inertia about all axes rotates about the angular momentum. The rest of the motion is made of short
/// rotations about the two other principal axes, one after the other (Dullweber, Leimkuhler & McLachlan, J.
/// Chem. Phys. 107 (1997), 5840). Angular momentum is constant, and errors do not grow from step to step.
/// Exact where two moments are equal. (The implicit midpoint rule, solved by repeated substitution, diverges
/// for slender bodies: a small tilt of the axis is a fast rotation about it.)
[[nodiscard]] Vec3 free_angle(const RigidMotion& start, double time_step);

/// A body's symmetric matrix, rotated with the body, times a vector.
inline Vec3 multiply_rotated(const Quaternion& rotation, const Matrix3& matrix, const Vec3& a) {
  return rotated(rotation, matrix * rotated_back(rotation, a));
}

}  // namespace palpate::fem
