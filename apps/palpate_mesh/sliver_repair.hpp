#pragma once

#include <array>
#include <cstddef>
#include <functional>

#include "domain_mesher.hpp"

namespace palpate::app {

/// Settings of the repair: how far points may move, and how often.
struct SliverRepair {
  double wanted_angle = 10.0;  ///< degrees; tets with a smaller dihedral angle are improved
  SizeField reach;             ///< how far a point of an interface may move from where it was
  int rounds = 12;
  std::function<void()> check;  ///< called often; may throw to stop
};

/// The least dihedral angle of a tet, degrees; 0 where it is flat or inverted.
double least_dihedral_angle(const std::array<Vec3, 4>& tet);

/// Moves points of tets with small dihedral angles so that the least angle of the tets at a point grows, one
/// point after the other, by pattern search (Hooke and Jeeves 1961). The connectivity stays, and all volumes
/// stay positive. No least angle becomes smaller. Returns how many tets are still below the angle. O(rounds x
/// such tets).
std::size_t repair_slivers(LabelledMesh& mesh, const SliverRepair& repair);

}  // namespace palpate::app
