#pragma once

#include <span>

#include <palpate/mesh.hpp>

#include "contact/swept_query.hpp"

namespace palpate {

/// Straight motions of the points of bodies.
struct StraightPaths {
  const Bodies& bodies;
  std::span<const Vec3> start;  ///< (n_points x 3), m
  std::span<const Vec3> end;    ///< (n_points x 3), m
};

/// The direction from which one primitive enters the other's body; zero if it does not come from outside. It
/// is that of the touch if the surface at the touch faces it; otherwise the normal of the triangle: where two
/// triangles lie flat beside each other, a point that slides over their common edge may touch this edge in an
/// oblique direction. When two closed surfaces first meet, the direction leads out of both. Once they
/// overlap, parts of them come from inside. O(1), at a corner O(edges at it).
Vec3 entry_direction(const SweptContact& contact, const StraightPaths& paths);

/// The direction of a touch at the end of the paths. Where a body rotates by a large angle within a step, the
/// plane of the touch says nothing about its sides at the end. O(1).
Vec3 direction_at_end(const SweptContact& contact, const StraightPaths& paths);

}  // namespace palpate
