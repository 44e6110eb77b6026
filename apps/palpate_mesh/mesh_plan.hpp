#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "mesh_options.hpp"
#include "organ.hpp"

namespace palpate::app {

/// A meshed organ with its sizes and counts.
struct MeshedOrgan {
  TetMesh mesh;               ///< in world coordinates; all tets of positive volume
  double size = 0.0;          ///< size of triangles that it was meshed with, mm
  double shape_volume = 0.0;  ///< of the smooth shape that was meshed, mm^3
  int shape_components = 0;
  bool manifold = true;     ///< whether the mesher was asked for a manifold surface
  int mesh_components = 0;  ///< parts that no path through faces joins
  int meshings = 0;         ///< number of meshings in the search for a number of tets
  double seconds = 0.0;
};

/// All meshed organs, and what to tell the user.
struct MeshedOrgans {
  std::vector<MeshedOrgan> organs;
  std::vector<std::string> warnings;  ///< where a number of tets was asked for and missed by over a tenth
};

/// Called before each meshing: the organ's index and the size. May throw to stop.
using MeshingStarts = std::function<void(std::size_t, double)>;

/// Meshes all organs. Where a number of tets is asked for, by a search over the size (secant in logarithms,
/// at most eight meshings; it stops within 2 %, and else the nearest is used, but none that lacks half of the
/// volume). `check` is called often while
/// a mesh is made; it may throw to stop. Throws Error naming an organ of which nothing could be meshed. The
/// same input gives the same meshes.
MeshedOrgans mesh_organs(const std::vector<Organ>& organs, const Fineness& fineness,
                         const MeshingStarts& starts, const std::function<void()>& check);

}  // namespace palpate::app
