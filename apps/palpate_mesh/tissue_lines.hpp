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
  /// (n_points), neighbours: two; four at a junction, one at an end.
  std::vector<std::vector<std::size_t>> next;
};

/// Finds the lines between voxel centres of at least three tissues, with a step of a third of a voxel. A line
/// ends where it leaves these cells. The same map gives the same lines. O(voxels).
TissueLines tissue_lines(const Tissues& tissues);

/// All edges of the graph, each once.
std::vector<std::array<Vec3, 2>> segments_of(const TissueLines& lines);

}  // namespace palpate::app
