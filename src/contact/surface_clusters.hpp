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

  Clusters clusters;           ///< of the surface triangles
  std::vector<Range> of_body;  ///< (n_bodies) clusters
  Rows points;                 ///< per cluster: its points, ascending
  Rows edges;                  ///< per cluster: its edges, as indices into Bodies::edges()
};

}  // namespace palpate
