#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "surface.hpp"

namespace palpate::app {

/// Pairs of triangles of a surface that intersect or touch elsewhere than in their common points.
struct SelfIntersections {
  std::size_t pairs = 0;
  std::vector<std::array<Vec3, 2>>
      segments;  ///< the intersections: one segment per pair, of length 0 for a point
};

/// Finds self-intersections. Pairs with a common edge are left out: they meet elsewhere only where one is
/// folded onto the other. Exact (CGAL, "Intersecting Sequences of dD Iso-oriented Boxes"). O(n log^3 n +
/// pairs whose boxes overlap).
SelfIntersections self_intersections(const Surface& surface);

}  // namespace palpate::app
