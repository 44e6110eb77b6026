#pragma once

#include <algorithm>
#include <array>
#include <span>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"

namespace palpate {

inline std::array<Vec3, 3> corners_of(std::span<const Vec3> positions, const Triangle& t) {
  return {at(positions, t[0]), at(positions, t[1]), at(positions, t[2])};
}

/// A normal of length twice the area, to the side from which the corners are seen counter-clockwise.
inline Vec3 area_vector(const std::array<Vec3, 3>& corners) {
  return cross(corners[1] - corners[0], corners[2] - corners[0]);
}

inline Vec3 area_vector(std::span<const Vec3> positions, const Triangle& t) {
  return area_vector(corners_of(positions, t));
}

/// Height of the third corner of a triangle over the plane through its side (a, b) with this unit normal, m.
/// If that is the outward normal of the other triangle at the side, it is above zero where the surface bends
/// inwards.
inline double height_of_third(std::span<const Vec3> positions, const Triangle& t, Index a, Index b,
                              const Vec3& normal) {
  const Index third = *std::find_if(t.begin(), t.end(), [&](Index p) { return p != a && p != b; });
  return dot(normal, at(positions, third) - at(positions, a));
}

/// Weights of a point of a triangle, none negative, sum 1; all equal where the triangle has no area.
/// \param area  area_vector() of the corners
inline std::array<double, 3> weights_in(const std::array<Vec3, 3>& corners, const Vec3& area, const Vec3& x) {
  std::array<double, 3> w{};
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += w[i] = std::max(0.0, dot(cross(corners[(i + 1) % 3] - x, corners[(i + 2) % 3] - x), area));
  if (!(sum > 0.0)) return {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
  for (double& weight : w) weight /= sum;
  return w;
}

}  // namespace palpate
