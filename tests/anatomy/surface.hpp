#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

/// Checks of a mesh, from its tets alone.
namespace palpate::test {

/// Numbers of surface triangles at the edges of a body's surface.
struct SurfaceCheck {
  bool closed = true;  ///< an even number at each edge
  int odd_edges = 0;   ///< edges with more than two
  int euler = 0;       ///< points - edges + triangles of the surface
};

inline SurfaceCheck surface_check(const Bodies& bodies, Index body) {
  std::map<std::pair<Index, Index>, int> edges;
  std::map<Index, int> points;
  const Range range = at(bodies.bodies(), body).triangles;
  for (Index t = range.begin; t < range.end; ++t) {
    const Triangle& triangle = at(bodies.triangles(), t);
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = triangle[i];
      const Index b = triangle[(i + 1) % 3];
      const std::pair<Index, Index> edge{std::min(a, b), std::max(a, b)};
      ++edges[edge];
      ++points[triangle[i]];
    }
  }
  SurfaceCheck check;
  for (const auto& [edge, count] : edges) {
    check.closed = check.closed && count % 2 == 0;
    check.odd_edges += count > 2 ? 1 : 0;
  }
  check.euler = static_cast<int>(points.size()) - static_cast<int>(edges.size()) + range.size();
  return check;
}

}  // namespace palpate::test
