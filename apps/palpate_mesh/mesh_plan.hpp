#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "organ.hpp"

namespace palpate::app {

/// How fine the organs are to be: a size, or a number of tets for which the size is searched.
struct Fineness {
  struct Named {
    std::string organ;
    double value;
  };
  double size = 0.0;                   ///< mm, of surface triangles; 0: by the number of tets
  std::vector<Named> sizes;            ///< for organs with a size of their own
  double tets = 0.0;                   ///< of all organs that are not named, together
  double tets_each = 0.0;              ///< of each organ that is not named, in place of `tets`
  std::vector<Named> named_tets;       ///< for organs with a number of their own
  double cell_share = 0.9;             ///< size of tets over that of triangles
  double distance_share = 0.14;        ///< distance of triangles from the surface over their size
  std::size_t max_points = 2'000'000;  ///< of a mesh
};

/// A meshed organ and what is worth knowing of it.
struct MeshedOrgan {
  TetMesh mesh;               ///< in world coordinates; all tets of positive volume
  double size = 0.0;          ///< mm, that it was meshed with
  double shape_volume = 0.0;  ///< of the smooth shape that was meshed, mm^3
  int shape_components = 0;
  int mesh_components = 0;  ///< parts that no path through faces joins
  int meshings = 0;         ///< how often it was meshed to meet a number of tets
  double seconds = 0.0;
};

/// Called before each meshing: the organ's index and the size. May throw to stop.
using MeshingStarts = std::function<void(std::size_t, double)>;

/// Meshes all organs. Where a number of tets is asked for, by a search over the size (secant in logarithms,
/// at most eight meshings; it stops within 2 % and takes the nearest). `check` is called often while a mesh
/// is made; what it throws stops the work. Throws Error naming an organ of which no mesh is left. The same
/// input gives the same meshes.
std::vector<MeshedOrgan> mesh_organs(const std::vector<Organ>& organs, const Fineness& fineness,
                                     const MeshingStarts& starts, const std::function<void()>& check);

}  // namespace palpate::app
