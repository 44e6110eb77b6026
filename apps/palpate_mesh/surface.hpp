#pragma once

#include <string>
#include <vector>

#include <palpate/types.hpp>

#include "surface_file.hpp"

namespace palpate::app {

/// An indexed triangle mesh.
struct Surface {
  std::vector<Vec3> points;         ///< those of the file in its order; not all are used
  std::vector<Triangle> triangles;  ///< in the order of the file; of points at one position the first
};

/// The polygons of a file as triangles. Points with the same coordinates are merged, and triangles without
/// three different points are removed. Of equal triangles one is kept. Two triangles with opposite sides are
/// both removed (such as the wall between two boxes), unless nothing would be left. O(n log n).
Surface surface_of(PolygonFile file);

/// A position as text for messages: "(1.5, -2, 30)".
std::string place_text(const Vec3& p);

}  // namespace palpate::app
