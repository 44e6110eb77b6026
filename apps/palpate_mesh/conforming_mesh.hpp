#pragma once

#include <functional>
#include <vector>

#include "map_comparison.hpp"
#include "tissue_plan.hpp"

namespace palpate::app {

/// One mesh of all tissues of a map, its bodies and its quality.
struct ConformingMesh {
  LabelledMesh mesh;                 ///< in the axes of the map; labels are tissues, from 1
  std::vector<InterfaceFace> faces;  ///< between tissues, and between them and the outside
  std::vector<TissueBody> bodies;    ///< in the axes of the map
  MapComparison comparison;
  double size = 0.0;        ///< general size of triangles, mm
  double least_size = 0.0;  ///< size in the thinnest layers
  int meshings = 0;
  double wanted_tets = 0.0;  ///< number that the user asked for; 0: none
};

/// Callbacks of a mesher. Each may throw an exception to stop it.
struct MeshingProgress {
  std::function<void(double size)> starts;  ///< called before each meshing
  std::function<void()> check;              ///< often
};

/// Meshes the tissues of a map without gaps between them, to a size or a number of tets (a search over the
/// size, at most six meshings), repairs slivers, cuts the mesh into bodies and compares it with the map. The
/// same input gives the same mesh. Throws Error if no mesh can be made or relations contradict each other.
/// Half a minute for 50 000 tets.
ConformingMesh mesh_conforming(const NamedMap& map, const TissuePlan& plan, const MeshOptions& options,
                               const MeshingProgress& progress);

}  // namespace palpate::app
