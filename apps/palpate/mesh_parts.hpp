#pragma once

#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::app {

/// How a mesh hangs together.
struct MeshParts {
  std::vector<double> volumes;   ///< of the pieces that no path through faces joins, largest first
  Index nonmanifold_edges = 0;   ///< of the surface, with four or more triangles
  Index nonmanifold_points = 0;  ///< of the surface, where triangles meet that no path over edges there joins
};

/// Of one body. O(n log n).
MeshParts mesh_parts(const Bodies& bodies, Index body);

}  // namespace palpate::app
