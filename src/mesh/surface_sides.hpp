#pragma once

#include <array>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate {

/// Which surface triangle is which face of a tet.
class TriangleOfFace {
 public:
  /// O(tets).
  explicit TriangleOfFace(const Bodies& bodies);
  /// The surface triangle that is the face opposite corner `opposite` of a tet; the face is at the surface.
  [[nodiscard]] Index operator()(const Bodies& bodies, Index tet, std::size_t opposite) const {
    Index triangle = first_[static_cast<std::size_t>(tet)];
    for (std::size_t i = 0; i < opposite; ++i)
      triangle += bodies.tet_neighbors()[static_cast<std::size_t>(tet)][i] < 0 ? 1 : 0;
    return triangle;
  }

 private:
  std::vector<Index> first_;  ///< (n_tets) triangles are in the order of their tets
};

/// How the surface triangles hang together at their sides. Side i of a triangle is opposite its corner i.
struct SurfaceSides {
  std::vector<std::array<Index, 3>> edges;  ///< (n_triangles) of Bodies::edges()
  /// (n_triangles) the triangle across each side; -1 where more than two meet there.
  std::vector<std::array<Index, 3>> neighbors;
  /// (n_edges) two of the triangles at each edge; -1, -1 inside a body.
  std::vector<std::array<Index, 2>> triangles;

  [[nodiscard]] bool is_on_surface(Index edge) const {
    return triangles[static_cast<std::size_t>(edge)][0] >= 0;
  }
};

/// O(triangles x edges at a point).
SurfaceSides surface_sides(const Bodies& bodies);

}  // namespace palpate
