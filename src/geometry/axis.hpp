#pragma once

#include <cstddef>

#include <palpate/types.hpp>

namespace palpate {

/// The axis (0 to 2) along which a vector is longest; the first of equal ones.
[[nodiscard]] constexpr std::size_t longest_axis(const Vec3& d) {
  return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

/// The coordinate of a point along an axis (0 to 2).
[[nodiscard]] constexpr double along(std::size_t axis, const Vec3& p) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

}  // namespace palpate
