#include "scene/near.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "contact/nearest_surface.hpp"
#include "geometry/triangle.hpp"
#include "mesh/faces.hpp"

namespace palpate {
namespace {

/// Whether one coordinate alone shows that a point is too far from a triangle; a fast test.
bool is_far(const Vec3& p, const std::array<Vec3, 3>& t, double reach) {
  const auto apart = [&](double Vec3::*axis) {
    const auto [low, high] = std::minmax({t[0].*axis, t[1].*axis, t[2].*axis});
    return p.*axis < low - reach || p.*axis > high + reach;
  };
  return apart(&Vec3::x) || apart(&Vec3::y) || apart(&Vec3::z);
}

bool holds(std::span<const Vec3> positions, const Tet& tet, const Vec3& p) {
  for (const auto& [i, j, k] : outward_face) {
    const Vec3& a = at(positions, tet[i]);
    const Vec3 normal = cross(at(positions, tet[j]) - a, at(positions, tet[k]) - a);
    if (dot(p - a, normal) > 0.0) return false;
  }
  return true;
}

}  // namespace

bool is_near(const Bodies& bodies, Index body, const Vec3& point, double distance) {
  const Range range = at(bodies.bodies(), body).triangles;
  for (Index t = range.begin; t < range.end; ++t) {
    const std::array<Vec3, 3> corners = corners_of(bodies.points_rest(), at(bodies.triangles(), t));
    if (is_far(point, corners, distance)) continue;
    if (length(nearest_on_triangle(point, corners) - point) <= distance) return true;
  }
  return false;
}

Index nearest_tet(const Bodies& bodies, std::span<const Vec3> positions, Index body, const Vec3& point) {
  const Body& range = at(bodies.bodies(), body);
  for (Index t = range.tets.begin; t < range.tets.end; ++t) {
    if (holds(positions, at(bodies.tets(), t), point)) return t;
  }
  double least = std::numeric_limits<double>::infinity();
  Index nearest = range.triangles.begin;
  for (Index t = range.triangles.begin; t < range.triangles.end; ++t) {
    const Vec3 foot = nearest_on_triangle(point, corners_of(positions, at(bodies.triangles(), t)));
    if (squared_length(foot - point) >= least) continue;
    least = squared_length(foot - point);
    nearest = t;
  }
  return at(bodies.triangle_tets(), nearest);
}

}  // namespace palpate
