#pragma once

#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::app {

/// Connected pieces of a mesh, and where its surface is no manifold.
struct MeshParts {
  std::vector<double> volumes;  ///< of the pieces that are connected through faces, largest first
  Index nonmanifold_edges = 0;  ///< of the surface, with four or more triangles
  Index nonmanifold_points =
      0;  ///< of the surface, where triangles meet that are not connected by edges at the point
};

/// Computes them for one body. O(n log n).
MeshParts mesh_parts(const Bodies& bodies, Index body);

}  // namespace palpate::app
