#pragma once

#include <string>
#include <vector>

#include <palpate/types.hpp>

#include "surface_file.hpp"

namespace palpate::app {

/// Triangles that share points.
struct Surface {
  std::vector<Vec3> points;         ///< those of the file in its order; not all are used
  std::vector<Triangle> triangles;  ///< in the order of the file; of points at one place the first
};

/// The polygons of a file as triangles. Points at one place become one, triangles without three different
/// points go. A triangle that is there twice stays once; two that face each other cancel out, as the wall
/// between two boxes that were put together, but not where nothing would be left. O(n log n).
Surface surface_of(PolygonFile file);

/// "(1.5, -2, 30)": a place for messages.
std::string place_text(const Vec3& p);

}  // namespace palpate::app
