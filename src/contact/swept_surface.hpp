#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "mesh/clusters.hpp"

namespace palpate {

/// The surfaces of all bodies, in clusters of up to 16 triangles. Each surface point and edge belongs to one
/// cluster: the first that has it as a corner or side. Fixed, as the meshes are.
struct SweptSurface {
  explicit SweptSurface(const Bodies& bodies);

  /// Unit normal of a triangle, out of its body; zero where it has no area. O(1).
  [[nodiscard]] static Vec3 outward(const Bodies& bodies, std::span<const Vec3> positions, Index triangle);
  /// Triangles at a surface edge; -1: none. Of more than two, the first two.
  [[nodiscard]] const std::array<Index, 2>& triangles_at(Index edge) const {
    return at(edge_triangles_, edge);
  }
  /// Sum of the normals of the triangles at a surface edge. O(1).
  [[nodiscard]] Vec3 outward_of_edge(const Bodies& bodies, std::span<const Vec3> positions, Index edge) const;

  Clusters clusters;                ///< of the surface triangles
  std::vector<Range> of_body;       ///< (n_bodies) clusters
  Rows points;                      ///< per cluster: those that belong to it, ascending
  Rows edges;                       ///< per cluster: the same of edges, as in Bodies::edges()
  std::vector<double> thickness;    ///< per cluster: least height of the tets behind its triangles at rest, m
  std::vector<double> of_thinnest;  ///< (n_bodies) least of its clusters, m

 private:
  std::vector<std::array<Index, 2>> edge_triangles_;  ///< (n_edges)
};

/// The tet behind a surface triangle. O(tets at a point).
[[nodiscard]] Index tet_behind(const Bodies& bodies, Index triangle);
/// Height of that tet over the triangle at rest, m; 0 where the triangle has no area.
[[nodiscard]] double height_behind(const Bodies& bodies, Index triangle);

}  // namespace palpate
