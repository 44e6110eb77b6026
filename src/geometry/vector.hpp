#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>

#include <palpate/types.hpp>

namespace palpate {

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator-(const Vec3& a) {
  return {-a.x, -a.y, -a.z};
}
constexpr Vec3 operator*(double s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
constexpr Vec3& operator+=(Vec3& a, const Vec3& b) {
  return a = a + b;
}
constexpr Vec3& operator-=(Vec3& a, const Vec3& b) {
  return a = a - b;
}

constexpr double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double squared_length(const Vec3& a) {
  return dot(a, a);
}
inline double length(const Vec3& a) {
  return std::sqrt(dot(a, a));
}

/// a / |a|, or the zero vector where |a| is zero or not finite.
inline Vec3 normalized(const Vec3& a) {
  const double l = length(a);
  return l > 0.0 && std::isfinite(l) ? (1.0 / l) * a : Vec3{};
}

/// The part of a vector across a unit direction.
inline Vec3 across(const Vec3& a, const Vec3& direction) {
  return a - dot(a, direction) * direction;
}
inline bool is_finite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Element i of a span or vector, for signed indices: keeps the sign conversion in one place.
constexpr decltype(auto) at(auto&& array, std::integral auto i) {
  return array[static_cast<std::size_t>(i)];
}

}  // namespace palpate
