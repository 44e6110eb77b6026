#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>

#include <palpate/mesh.hpp>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/rational.hpp"

/// Whether two bodies meet, by brute force: all pairs of their surface triangles in exact arithmetic, and
/// points in tets. Triangles are tested by separating axes, which share nothing with the tests of src/. A
/// plane between two triangles proves that they are apart, so a fault here could only find bodies that meet
/// where there is no contact.
namespace palpate::test {

template <class Number>
using Corners = std::array<std::array<Number, 3>, 3>;

template <class Number>
std::array<Number, 3> cross_product(const std::array<Number, 3>& u, const std::array<Number, 3>& v) {
  return {Number(u[1] * v[2] - u[2] * v[1]), Number(u[2] * v[0] - u[0] * v[2]),
          Number(u[0] * v[1] - u[1] * v[0])};
}

/// Whether one of the axes that matter is one that `separates`. Closed triangles without a common point have
/// a plane between them, which touches neither, across their normals, a product of their sides, or, if both
/// are in one plane, across a side in this plane: the facets of the set of their differences.
template <class Number, class Separates>
bool any_axis(const Corners<Number>& a, const Corners<Number>& b, Separates&& separates) {
  Corners<Number> sides_a;
  Corners<Number> sides_b;
  for (std::size_t i = 0; i < 3; ++i) {
    sides_a[i] = minus(a[(i + 1) % 3], a[i]);
    sides_b[i] = minus(b[(i + 1) % 3], b[i]);
  }
  const auto normal = cross_product(sides_a[0], sides_a[1]);
  if (separates(normal) || separates(cross_product(sides_b[0], sides_b[1]))) return true;
  for (const auto& u : sides_a)
    for (const auto& v : sides_b)
      if (separates(cross_product(u, v))) return true;
  for (const auto* sides : {&sides_a, &sides_b})
    for (const auto& u : *sides)
      if (separates(cross_product(normal, u))) return true;
  return false;
}

/// Distances of the corners along an axis: the least and the largest, each moved by the error.
template <class Number>
std::array<Number, 2> range_along(const std::array<Number, 3>& axis, const Corners<Number>& corners) {
  std::array<Number, 3> low;
  std::array<Number, 3> high;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& p = corners[i];
    low[i] = high[i] = axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    if constexpr (std::is_floating_point_v<Number>) {
      // Three products and two sums have an error of at most three roundings of `size` (of half an epsilon
      // each) and three underflows; the sum with the error has one more.
      using Limits = std::numeric_limits<Number>;
      const Number size = std::abs(axis[0] * p[0]) + std::abs(axis[1] * p[1]) + std::abs(axis[2] * p[2]);
      if (!std::isfinite(size)) return {-Limits::infinity(), Limits::infinity()};
      const Number error = 4.0 * Limits::epsilon() * size + Limits::min();
      low[i] -= error;
      high[i] += error;
    }
  }
  return {*std::ranges::min_element(low), *std::ranges::max_element(high)};
}

/// Whether a plane across one of the axes surely separates the triangles. In doubles an axis is rounded, but
/// each axis is as good as any other.
template <class Number>
bool are_apart(const Corners<Number>& a, const Corners<Number>& b) {
  return any_axis(a, b, [&](const std::array<Number, 3>& axis) {
    const auto along_a = range_along(axis, a);
    const auto along_b = range_along(axis, b);
    return along_a[1] < along_b[0] || along_b[1] < along_a[0];
  });
}

/// How two bodies meet.
struct Meeting {
  bool surfaces = false;  ///< triangles have a common point
  bool nested = false;    ///< one is inside the other, and surfaces do not meet
  bool close = false;     ///< doubles could not decide
};

/// Whether closed triangles have a common point.
inline bool triangles_meet(std::span<const Vec3> x, const Triangle& a, const Triangle& b, bool& close) {
  if (!box_of(x, a).overlaps(box_of(x, b))) return false;
  const auto corners = [&](const Triangle& t) {
    Corners<double> c;
    for (std::size_t i = 0; i < 3; ++i) c[i] = {at(x, t[i]).x, at(x, t[i]).y, at(x, t[i]).z};
    return c;
  };
  if (are_apart(corners(a), corners(b))) return false;
  close = true;
  const auto p =
      scaled_to_integers<6>({at(x, a[0]), at(x, a[1]), at(x, a[2]), at(x, b[0]), at(x, b[1]), at(x, b[2])});
  return !are_apart<Integer>({p[0], p[1], p[2]}, {p[3], p[4], p[5]});
}

/// Whether a point of one body is in a tet of the other one.
inline bool has_point_in(const Bodies& bodies, std::span<const Vec3> x, const Body& one, const Body& other) {
  for (Index t = other.tets.begin; t < other.tets.end; ++t) {
    const Tet& tet = at(bodies.tets(), t);
    const Box box = box_of(x, tet);
    for (Index p = one.points.begin; p < one.points.end; ++p) {
      if (box.contains(at(x, p)) &&
          rational_point_in_tet(at(x, p), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3])))
        return true;
    }
  }
  return false;
}

/// How two bodies meet.
inline Meeting rational_meeting(const Bodies& bodies, std::span<const Vec3> x, Index a, Index b) {
  const Body& first = at(bodies.bodies(), a);
  const Body& second = at(bodies.bodies(), b);
  const auto box_of_points = [&](const Body& body) {
    Box box;
    for (Index p = body.points.begin; p < body.points.end; ++p) box.extend(at(x, p));
    return box;
  };
  Meeting found;
  const Box other = box_of_points(second);
  if (!box_of_points(first).overlaps(other)) return found;
  for (Index s = first.triangles.begin; s < first.triangles.end; ++s) {
    const Triangle& own = at(bodies.triangles(), s);
    if (!box_of(x, own).overlaps(other)) continue;
    for (Index t = second.triangles.begin; t < second.triangles.end && !found.surfaces; ++t)
      found.surfaces = triangles_meet(x, own, at(bodies.triangles(), t), found.close);
    if (found.surfaces) return found;
  }
  found.nested = has_point_in(bodies, x, first, second) || has_point_in(bodies, x, second, first);
  return found;
}

}  // namespace palpate::test
