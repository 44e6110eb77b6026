#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <palpate/types.hpp>

#include "tissues.hpp"

namespace palpate::app {

/// The lines where three tissues meet (the outside counts as one), as a graph in the axes of the map.
struct TissueLines {
  std::vector<Vec3> points;
  std::vector<std::vector<std::size_t>> next;  ///< (n_points), neighbours: two, or four at a junction
};

/// Finds the lines in the tissues at the voxel centres and around them. The same map gives the same
/// lines. O(voxels).
TissueLines tissue_lines(const Tissues& tissues);

/// All edges of the graph, each once.
std::vector<std::array<Vec3, 2>> segments_of(const TissueLines& lines);

}  // namespace palpate::app
