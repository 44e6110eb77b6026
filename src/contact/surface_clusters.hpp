#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "mesh/clusters.hpp"

namespace palpate {

/// The surfaces of all bodies in clusters of up to 16 triangles. Each surface point and edge belongs to one
/// cluster: the first one of which it is a corner or side. Constant, since meshes are.
struct SurfaceClusters {
  explicit SurfaceClusters(const Bodies& bodies);

  Clusters clusters;              ///< of the surface triangles
  std::vector<Range> of_body;     ///< (n_bodies) clusters
  Rows points;                    ///< per cluster: its points, ascending
  Rows edges;                     ///< per cluster: its edges, as indices into Bodies::edges()
  std::vector<double> thickness;  ///< per cluster: minimum height of the tets behind its triangles at rest, m
  std::vector<double> of_thinnest;  ///< (n_bodies) minimum of its clusters, m
};

/// Height of the tet behind a surface triangle, at rest, m; 0 where the triangle has no area.
[[nodiscard]] double height_behind(const Bodies& bodies, Index triangle);

}  // namespace palpate
