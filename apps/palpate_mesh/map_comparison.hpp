#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "domain_mesher.hpp"
#include "tet_faces.hpp"
#include "tissue_lines.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// Distances between two surfaces or lines, mm.
struct ShapeDistance {
  double mean = 0.0;
  double percentile_95 = 0.0;  ///< 95 % of the distances are at most this
  double largest = 0.0;        ///< Hausdorff distance
};

/// Comparison of a tissue of a mesh with its voxels.
struct TissueMatch {
  std::size_t tets = 0;
  std::size_t voxels = 0;
  double volume = 0.0;      ///< of its tets, mm^3
  double map_volume = 0.0;  ///< of its voxels
  double dice = 0.0;        ///< Dice coefficient of its voxels and the voxels with their centre in its tets
  std::size_t lost =
      0;  ///< voxels that the mesh misses: neither they nor their 26 neighbours have their centre in its tets
  ShapeDistance distance;      ///< from triangles to the faces of voxels, and back
  double least_angle = 180.0;  ///< dihedral, of its tets, degrees
};

/// Comparison of the interface of two tissues in map and mesh.
struct InterfaceMatch {
  std::array<int, 2> tissues{};
  double map_area = 0.0;  ///< of the faces between their voxels, mm^2
  double closed_area =
      0.0;  ///< of those faces where at most 0.1 mm of the line between the two centres is in no tet
  double area = 0.0;  ///< of their common triangles in the mesh
  std::size_t triangles = 0;
};

struct MapComparison {
  std::vector<TissueMatch> tissues;        ///< (n_tissues)
  std::vector<InterfaceMatch> interfaces;  ///< of all pairs that touch in map or mesh, sorted by tissues
  /// From edges of the mesh where three tissues meet to such lines of the map, and back; none if either has
  /// no line.
  std::optional<ShapeDistance> lines;
};

/// Compares a mesh in the axes of the map with the map, and with the lines where its tissues meet. O(tets x
/// lines of voxels in each + voxels).
MapComparison compare(const Tissues& tissues, const TissueLines& map_lines, const LabelledMesh& mesh,
                      const std::vector<InterfaceFace>& faces);

}  // namespace palpate::app
