#include "contact/swept_sides.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

/// Tolerance (a cosine) for a direction that is outside the range of normals at an edge.
constexpr double most_outside = 0.1;
/// Cosine of the angle up to which a direction counts as the normal of a triangle.
constexpr double along_normal = 0.995;
/// Weight of a corner up to which a place counts as on the opposite edge.
constexpr double on_rim = 1e-3;
/// Sine of the angle between two edges below which they count as parallel.
constexpr double least_sine = 0.1;
/// Cosine of the angle up to which a direction counts as orthogonal to both edges.
constexpr double least_orthogonal = 0.9;

/// Position of a point at a time of the step, in [0, 1].
Vec3 place(const StraightPaths& paths, Index point, double time) {
  const Vec3& from = at(paths.start, point);
  return from + time * (at(paths.end, point) - from);
}

/// Whether a direction leads out of the body at an edge: it points into neither of the edge's triangles.
bool is_left_by(const SweptContact& contact, Index edge, const Vec3& direction, const StraightPaths& paths) {
  const Edge& ends = at(paths.bodies.edges(), edge);
  const Vec3 from = place(paths, ends[0], contact.time);
  const Vec3 along = normalized(place(paths, ends[1], contact.time) - from);
  const auto into = [&](Index triangle) {
    for (const Index corner : at(paths.bodies.triangles(), triangle)) {
      if (corner == ends[0] || corner == ends[1]) continue;
      const Vec3 away = place(paths, corner, contact.time) - from;
      return dot(direction, normalized(away - dot(away, along) * along));
    }
    return 0.0;
  };
  return std::ranges::all_of(at(paths.bodies.edge_triangles(), edge),
                             [&](Index t) { return t < 0 || into(t) <= most_outside; });
}

/// Whether the direction of a touch leads out of the body at the edges of the triangle on which it lies.
bool is_left_at_rim(const SweptContact& contact, const StraightPaths& paths) {
  const Triangle& corners = at(paths.bodies.triangles(), contact.second);
  const auto& edges = at(paths.bodies.triangle_edges(), contact.second);
  const auto leaves = [&](Index edge) { return is_left_by(contact, edge, contact.direction, paths); };
  const auto corner = std::ranges::find_if(contact.weights, [](double w) { return w >= 1.0 - on_rim; });
  if (corner != contact.weights.end()) {
    const Index point = corners[static_cast<std::size_t>(corner - contact.weights.begin())];
    return std::ranges::all_of(paths.bodies.point_edges()[point], leaves);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (contact.weights[k] > on_rim) continue;
    const auto is_opposite = [&](Index edge) {
      return std::ranges::find(at(paths.bodies.edges(), edge), corners[k]) ==
             at(paths.bodies.edges(), edge).end();
    };
    const auto opposite = std::ranges::find_if(edges, is_opposite);
    return opposite != edges.end() && leaves(*opposite);
  }
  return false;
}

Vec3 into_triangle(const SweptContact& contact, const StraightPaths& paths) {
  std::array<Vec3, 3> x;
  for (std::size_t i = 0; i < 3; ++i)
    x[i] = place(paths, at(paths.bodies.triangles(), contact.second)[i], contact.time);
  const Vec3 normal = normalized(area_vector(x));
  const double cosine = dot(contact.direction, normal);
  if (!(cosine > 0.0)) return {};
  return cosine >= along_normal || is_left_at_rim(contact, paths) ? contact.direction : normal;
}

/// The direction rotates with the triangle.
Vec3 on_triangle_at_end(const SweptContact& contact, const StraightPaths& paths) {
  const Triangle& corners = at(paths.bodies.triangles(), contact.second);
  const auto axes = [&](double time) {
    std::array<Vec3, 3> x;
    for (std::size_t i = 0; i < 3; ++i) x[i] = place(paths, corners[i], time);
    const Vec3 along = normalized(x[1] - x[0]);
    const Vec3 normal = normalized(area_vector(x));
    return std::array<Vec3, 3>{along, cross(normal, along), normal};
  };
  const std::array<Vec3, 3> then = axes(contact.time);
  const std::array<Vec3, 3> end = axes(1.0);
  if (then[2] == Vec3{} || end[2] == Vec3{}) return contact.direction;
  Vec3 rotated;
  for (std::size_t i = 0; i < 3; ++i) rotated += dot(contact.direction, then[i]) * end[i];
  return normalized(rotated);
}

/// The direction stays orthogonal to both edges. If it is not, or if they are almost parallel, it does not
/// change.
Vec3 across_edges_at_end(const SweptContact& contact, const StraightPaths& paths) {
  const auto across = [&](double time) {
    const auto along = [&](Index edge) {
      const Edge& ends = at(paths.bodies.edges(), edge);
      return normalized(place(paths, ends[1], time) - place(paths, ends[0], time));
    };
    return cross(along(contact.first), along(contact.second));
  };
  const Vec3 then = across(contact.time);
  const Vec3 end = across(1.0);
  const double cosine = dot(contact.direction, normalized(then));
  if (std::min(length(then), length(end)) < least_sine || std::abs(cosine) < least_orthogonal)
    return contact.direction;
  return normalized(cosine < 0.0 ? -end : end);
}

}  // namespace

Vec3 entry_direction(const SweptContact& contact, const StraightPaths& paths) {
  if (contact.direction == Vec3{}) return {};
  if (contact.kind == SweptKind::point_triangle) return into_triangle(contact, paths);
  const bool enters = is_left_by(contact, contact.second, contact.direction, paths) &&
                      is_left_by(contact, contact.first, -contact.direction, paths);
  return enters ? contact.direction : Vec3{};
}

Vec3 direction_at_end(const SweptContact& contact, const StraightPaths& paths) {
  return contact.kind == SweptKind::edge_edge ? across_edges_at_end(contact, paths)
                                              : on_triangle_at_end(contact, paths);
}

}  // namespace palpate
