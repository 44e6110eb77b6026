#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "domain_mesher.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// What a mesh covers of the lines through the centres of voxels.
struct VoxelLines {
  std::vector<std::uint16_t> tissues;  ///< (n_voxels), at the centre of each; 0: none
  /// For each axis (n_voxels): mm of the way from the centre before to that of the voxel which is in tets.
  std::array<std::vector<float>, 3> covered;
};

/// O(tets x lines in each).
VoxelLines covered_lines(const Tissues& tissues, const LabelledMesh& mesh);

}  // namespace palpate::app
