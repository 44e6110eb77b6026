#pragma once

#include <span>

#include <palpate/mesh.hpp>

#include "geometry/triangle.hpp"

namespace palpate {

/// Sum of the unit normals of the surface triangles at an edge, out of its body; zero inside it. O(1).
inline Vec3 outward_of_edge(const Bodies& bodies, std::span<const Vec3> positions, Index edge) {
  Vec3 sum;
  for (const Index triangle : at(bodies.edge_triangles(), edge))
    if (triangle >= 0) sum += normalized(area_vector(positions, at(bodies.triangles(), triangle)));
  return sum;
}

}  // namespace palpate
