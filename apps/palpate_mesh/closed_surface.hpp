#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesh_options.hpp"
#include "surface.hpp"

namespace palpate::app {

/// A surface that separates inside from outside.
struct ClosedSurface {
  Surface surface;  ///< mm
  /// Segments along which parts of the surface touch or intersect, mm. A segment of length 0 is a point.
  std::vector<std::array<Vec3, 2>> joints;
  bool one_sided = true;  ///< all triangles face the same side
  std::vector<std::string>
      remarks;  ///< holes that were closed, edges of four triangles, self-intersections …
};

/// Closes the holes that are no larger than `shaping.close_holes` (none given: 5 % of the diagonal of the
/// surface's box) and converts the unit of the file to mm. Edges may have four triangles, where parts touch.
///
/// Throws Error naming the first edge that is left with an odd number of triangles, by its points (numbers
/// from 0) and coordinates as in the file, and what it belongs to: a hole, or three triangles at an edge.
ClosedSurface closed_surface(Surface surface, const Shaping& shaping, const std::string& source);

}  // namespace palpate::app
