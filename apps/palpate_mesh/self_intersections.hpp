#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "surface.hpp"

namespace palpate::app {

/// Pairs of triangles of a surface that meet elsewhere than in the points they share.
struct SelfIntersections {
  std::size_t pairs = 0;
  std::vector<std::array<Vec3, 2>> segments;  ///< where they meet: a line each, of no length for a point
};

/// Pairs with a common edge are not looked at: they meet elsewhere only where one lies on the other. Exact
/// (CGAL, "Intersecting Sequences of dD Iso-oriented Boxes"). O(n log^3 n + pairs whose boxes overlap).
SelfIntersections self_intersections(const Surface& surface);

}  // namespace palpate::app
