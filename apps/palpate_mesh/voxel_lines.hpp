#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "domain_mesher.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// The parts of the lines through voxel centres that a mesh covers.
struct VoxelLines {
  std::vector<std::uint16_t> tissues;  ///< (n_voxels), at the centre of each; 0: none
  /// For each axis (n_voxels): length in tets of the line from the previous voxel's centre to this one's, mm.
  std::array<std::vector<float>, 3> covered;
};

/// Computes them. O(tets x lines in each).
VoxelLines covered_lines(const Tissues& tissues, const LabelledMesh& mesh);

}  // namespace palpate::app
