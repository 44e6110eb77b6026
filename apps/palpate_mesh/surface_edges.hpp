#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "surface.hpp"

namespace palpate::app {

/// A gap in a surface: a ring of edges of one triangle each.
struct Hole {
  std::vector<Edge> edges;  ///< each in the direction of its triangle
  double size = 0.0;        ///< diagonal of its bounding box
};

/// Counts of the edges of a surface. A surface separates inside from outside if each edge has an even number
/// of triangles, also where four meet.
struct SurfaceEdges {
  std::vector<Hole> holes;  ///< by their first edge
  /// Edges with three, five … triangles, and edges with one triangle that are connected to them: no hole to
  /// close.
  std::size_t odd_edges = 0;
  std::vector<Edge> shared_edges;  ///< with four or more triangles, an even number
  bool one_sided = true;           ///< the triangles at each edge face the same side
  /// The first edge with an odd number of triangles (in the order of triangles), and that number; none for a
  /// closed surface.
  std::optional<Edge> first_bad;
  std::size_t triangles_at_first = 0;
};

/// O(n log n).
SurfaceEdges edges_of(const Surface& surface);

/// Points at which the triangles are not connected by edges at that point, ascending. O(n log n).
std::vector<Index> touching_points(const Surface& surface);

/// Closes a hole by a fan of triangles to the mean of its points.
void close_hole(Surface& surface, const Hole& hole);

}  // namespace palpate::app
