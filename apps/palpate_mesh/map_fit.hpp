#pragma once

#include <cstddef>

#include "domain_mesher.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// Settings of the fit.
struct MapFit {
  double wanted_angle = 10.0;  ///< degrees; no dihedral angle becomes smaller than this, or than it was
  double reach = 1.0;          ///< how far a point may move from where it was, in voxels
  int rounds = 4;
};

/// Moves points of interfaces so that less volume of the mesh has another tissue than the map: triangles of a
/// curved interface are chords, whose points are on it and whose middles are beside it. The volume is counted
/// by samples, eight to a voxel. One point after the other; a point moves only where that lowers the count
/// of its tets. The connectivity stays. Returns the number of moves. O(rounds x volume / voxel).
std::size_t fit_interfaces(LabelledMesh& mesh, const Tissues& tissues, const MapFit& fit = {});

}  // namespace palpate::app
