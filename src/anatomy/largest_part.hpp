#pragma once

#include <palpate/mesh.hpp>

namespace palpate::anatomy {

/// The connected part of a mesh, by faces, with the most tets (of equal ones the
/// first), with the points that it uses, in their order. O(n log n).
TetMesh largest_part(const TetMesh& mesh);

/// A mesh where no two parts of its surface meet in an edge: of the tets round such an edge only those of the
/// largest fan stay (hanging together by faces; of equal ones the first), again and again until there is
/// none. Points may still be shared by two parts of the surface. O(n log n) a round.
TetMesh without_pinched_edges(TetMesh mesh);

}  // namespace palpate::anatomy
