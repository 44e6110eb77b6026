#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "domain_mesher.hpp"
#include "tet_faces.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// Distances between two surfaces, mm.
struct SurfaceDistance {
  double mean = 0.0;
  double most_of_95 = 0.0;  ///< 95 % are no further
  double most = 0.0;        ///< Hausdorff distance
};

/// How a tissue of a mesh compares with its voxels.
struct TissueMatch {
  std::size_t tets = 0;
  std::size_t voxels = 0;
  double volume = 0.0;         ///< of its tets, mm^3
  double map_volume = 0.0;     ///< of its voxels
  double dice = 0.0;           ///< of its voxels and those with their centre in its tets
  std::size_t lost = 0;        ///< voxels with no such centre in them and their 26 neighbours
  SurfaceDistance distance;    ///< from triangles to the faces of voxels, and back
  double least_angle = 180.0;  ///< dihedral, of its tets, degrees
};

/// How two tissues that touch in the map do so in the mesh.
struct InterfaceMatch {
  std::array<int, 2> tissues{};
  double map_area = 0.0;     ///< of the faces between their voxels, mm^2
  double closed_area = 0.0;  ///< of those of them where at most 0.1 mm between the centres is in no tet
  double area = 0.0;         ///< of the triangles that they share in the mesh
  std::size_t triangles = 0;
};

struct MapComparison {
  std::vector<TissueMatch> tissues;        ///< (n_tissues)
  std::vector<InterfaceMatch> interfaces;  ///< by tissues; of all pairs that touch in map or mesh
};

/// Compares a mesh in the axes of the map with the map. O(tets x lines of voxels in each + voxels).
MapComparison compare(const Tissues& tissues, const LabelledMesh& mesh,
                      const std::vector<InterfaceFace>& faces);

}  // namespace palpate::app
