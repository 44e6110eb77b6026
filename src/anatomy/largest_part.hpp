#pragma once

#include <palpate/mesh.hpp>

namespace palpate::anatomy {

/// The connected part of a mesh, by faces, with the most tets (of equal ones the
/// first), with the points that it uses, in their order. O(n log n).
TetMesh largest_part(const TetMesh& mesh);

/// Removes tets until no two parts of the surface meet in an edge. Of the tets around such an edge, only the
/// largest fan stays (a fan is connected by faces; of equal fans the first). Two parts of the surface may
/// still have a common point. O(n log n) per round.
TetMesh without_pinched_edges(TetMesh mesh);

}  // namespace palpate::anatomy
