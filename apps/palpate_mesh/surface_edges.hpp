#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "surface.hpp"

namespace palpate::app {

/// A gap in a surface: a ring of edges of one triangle each.
struct Hole {
  std::vector<Edge> edges;  ///< each as its triangle goes along it
  double size = 0.0;        ///< diagonal of the box round it
};

/// What the edges of a surface say of its inside. An even number of triangles at each edge parts inside from
/// outside, also where four meet.
struct SurfaceEdges {
  std::vector<Hole> holes;  ///< by their first edge
  /// Edges of three, five … triangles, and those of one that hang on such: no hole to close.
  std::size_t odd_edges = 0;
  std::vector<Edge> shared_edges;  ///< of four or more triangles, an even number
  bool one_sided = true;           ///< the triangles at each edge face the same side
  /// The first edge, by its triangle, that parts nothing, and how many triangles it has; none for a closed
  /// surface.
  std::optional<Edge> first_bad;
  std::size_t triangles_at_first = 0;
};

/// O(n log n).
SurfaceEdges edges_of(const Surface& surface);

/// Points at which triangles meet that no path over edges at the point joins, ascending. O(n log n).
std::vector<Index> touching_points(const Surface& surface);

/// Closes a hole by triangles to the middle of its edges.
void close_hole(Surface& surface, const Hole& hole);

}  // namespace palpate::app
