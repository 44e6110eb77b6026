#pragma once

#include <algorithm>
#include <cmath>
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

/// Largest absolute coordinate.
inline double largest(const Box& box) {
  return std::max({std::abs(box.lower.x), std::abs(box.lower.y), std::abs(box.lower.z), std::abs(box.upper.x),
                   std::abs(box.upper.y), std::abs(box.upper.z)});
}

/// The box grown by `by` on all sides, rounded outwards.
inline Box grown(const Box& box, double by) {
  constexpr double rounding = 4e-16;
  const double more = by + rounding * (largest(box) + by);
  const Vec3 d{more, more, more};
  return {box.lower - d, box.upper + d};
}

/// Empty where the boxes do not meet.
inline Box common_part(const Box& a, const Box& b) {
  return {{std::max(a.lower.x, b.lower.x), std::max(a.lower.y, b.lower.y), std::max(a.lower.z, b.lower.z)},
          {std::min(a.upper.x, b.upper.x), std::min(a.upper.y, b.upper.y), std::min(a.upper.z, b.upper.z)}};
}

/// A lower bound on the distance between a point of one box and a point of the other: along an axis. Zero
/// where the boxes meet.
inline double gap(const Box& a, const Box& b) {
  constexpr double rounding = 1.0 - 1e-12;
  return rounding * std::max({0.0, a.lower.x - b.upper.x, b.lower.x - a.upper.x, a.lower.y - b.upper.y,
                              b.lower.y - a.upper.y, a.lower.z - b.upper.z, b.lower.z - a.upper.z});
}

/// An upper bound on the distance between a point of one box and a point of the other.
inline double largest_distance(const Box& a, const Box& b) {
  const Vec3 d{std::max(a.upper.x - b.lower.x, b.upper.x - a.lower.x),
               std::max(a.upper.y - b.lower.y, b.upper.y - a.lower.y),
               std::max(a.upper.z - b.lower.z, b.upper.z - a.lower.z)};
  constexpr double rounding = 1.0 + 1e-12;
  return rounding * length(d);
}

/// The same, also when coordinates are rounded.
inline double furthest(const Box& a, const Box& b) {
  constexpr double in_common = 4e-16;
  return largest_distance(a, b) + in_common * (largest(a) + largest(b));
}

/// The box of a primitive (tet, triangle, edge) whose corners index into `positions`.
template <class Corners>
Box box_of(std::span<const Vec3> positions, const Corners& corners) {
  Box box;
  for (const Index corner : corners) box.extend(at(positions, corner));
  return box;
}

}  // namespace palpate
