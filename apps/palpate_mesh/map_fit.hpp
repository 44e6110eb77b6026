#pragma once

#include <functional>

#include "domain_mesher.hpp"
#include "tissues.hpp"

namespace palpate::app {

/// Moves points of interfaces so that less volume of the mesh has another tissue than the map: triangles of a
/// curved interface are chords, whose points are on it and whose middles are beside it. The volume is counted
/// by samples, eight to a voxel. One point after the other; a point moves only where that lowers the count
/// of its tets. No point moves by more than 0.45 of a voxel (the cube root of its volume), none on a line
/// where three tissues meet by more than 0.25. No dihedral angle falls below 10 degrees, or below what it
/// was. The connectivity stays. O(volume / voxel).
/// \param check  called often; may throw to stop
void fit_interfaces(LabelledMesh& mesh, const Tissues& tissues, const std::function<void()>& check);

}  // namespace palpate::app
