#pragma once

#include <cstddef>

#include "surface.hpp"

namespace palpate::app {

/// Pairs of triangles of a surface that meet elsewhere than in the points they share.
struct SelfIntersections {
  std::size_t pairs = 0;
  Vec3 place;  ///< the middle of one triangle of the first pair
};

/// Pairs with a common edge are not looked at: they meet elsewhere only where one lies on the other. Exact
/// (CGAL, "Intersecting Sequences of dD Iso-oriented Boxes"). O(n log^3 n + pairs whose boxes overlap).
SelfIntersections self_intersections(const Surface& surface);

}  // namespace palpate::app
