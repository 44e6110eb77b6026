#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "geometry/vector.hpp"

namespace palpate {

/// Axis-aligned box; empty where lower > upper.
struct Box {
  Vec3 lower{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
             std::numeric_limits<double>::infinity()};
  Vec3 upper{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};

  void extend(const Vec3& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  void extend(const Box& other) {
    extend(other.lower);
    extend(other.upper);
  }
  [[nodiscard]] bool contains(const Vec3& p) const {
    return lower.x <= p.x && p.x <= upper.x && lower.y <= p.y && p.y <= upper.y && lower.z <= p.z &&
           p.z <= upper.z;
  }
  [[nodiscard]] bool overlaps(const Box& o) const {
    return lower.x <= o.upper.x && o.lower.x <= upper.x && lower.y <= o.upper.y && o.lower.y <= upper.y &&
           lower.z <= o.upper.z && o.lower.z <= upper.z;
  }
};

/// The box of a primitive (tet, triangle, edge) whose corners index into `positions`.
template <class Corners>
Box box_of(std::span<const Vec3> positions, const Corners& corners) {
  Box box;
  for (const Index corner : corners) box.extend(at(positions, corner));
  return box;
}

}  // namespace palpate
