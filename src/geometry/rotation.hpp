#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include <palpate/types.hpp>

#include "geometry/scaled_length.hpp"
#include "geometry/trigonometry.hpp"
#include "geometry/vector.hpp"

namespace palpate {

/// A unit quaternion: a rotation.
struct Quaternion {
  double scalar = 1.0;
  Vec3 vector{};
};

/// From (w, x, y, z) of any length but zero.
inline Quaternion quaternion_of(const std::array<double, 4>& quaternion) {
  const auto& [w, x, y, z] = quaternion;
  const double norm = scaled_length({w, scaled_length({x, y, z}), 0.0});
  return {w / norm, (1.0 / norm) * Vec3{x, y, z}};
}

/// About an axis of any length but zero, right-handed.
inline Quaternion rotation_about(const Vec3& axis, double degrees) {
  const double half = 0.5 * degrees * std::numbers::pi / 180.0;
  return {cosine(half), sine(half) * normalized(axis)};
}

/// By a rotation vector: its direction is the axis, its length the angle, rad.
inline Quaternion rotation_by(const Vec3& angle) {
  if (angle == Vec3{}) return {};
  return rotation_about(angle, 180.0 / std::numbers::pi * length(angle));
}

inline Vec3 rotated(const Quaternion& rotation, const Vec3& a) {
  const Vec3 t = 2.0 * cross(rotation.vector, a);
  return a + rotation.scalar * t + cross(rotation.vector, t);
}

/// By the inverse rotation.
inline Vec3 rotated_back(const Quaternion& rotation, const Vec3& a) {
  return rotated({rotation.scalar, -rotation.vector}, a);
}

/// Two rotations, the second argument first.
inline Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.scalar * b.scalar - dot(a.vector, b.vector),
          a.scalar * b.vector + b.scalar * a.vector + cross(a.vector, b.vector)};
}

/// The rotation vector of a rotation, its angle in [0, pi], rad.
inline Vec3 rotation_vector(const Quaternion& q) {
  const double sine_of_half = length(q.vector);
  if (sine_of_half == 0.0) return {};
  const double half = arc_tangent(sine_of_half, std::abs(q.scalar));
  return ((q.scalar < 0.0 ? -2.0 : 2.0) * half / sine_of_half) * q.vector;
}

/// Spherical linear interpolation (slerp) from a (fraction 0) to b (fraction 1) along the shorter arc.
inline Quaternion between(const Quaternion& a, Quaternion b, double fraction) {
  double cosine_between = a.scalar * b.scalar + dot(a.vector, b.vector);
  if (cosine_between < 0.0) {
    b = {-b.scalar, -b.vector};
    cosine_between = -cosine_between;
  }
  // For nearly equal rotations the sine of the angle loses its digits, and linear interpolation is exact up
  // to rounding.
  constexpr double nearly_equal = 1.0 - 1e-9;
  double part_a = 1.0 - fraction;
  double part_b = fraction;
  if (cosine_between < nearly_equal) {
    const double angle = arc_cosine(cosine_between);
    part_a = sine((1.0 - fraction) * angle) / sine(angle);
    part_b = sine(fraction * angle) / sine(angle);
  }
  const Vec3 vector = part_a * a.vector + part_b * b.vector;
  return quaternion_of({part_a * a.scalar + part_b * b.scalar, vector.x, vector.y, vector.z});
}

}  // namespace palpate
