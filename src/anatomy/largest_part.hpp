#pragma once

#include <palpate/mesh.hpp>

namespace palpate::anatomy {

/// The part of a mesh that holds the most tets among those that hang together by faces (of equal ones the
/// first), with the points that it uses, in their order. O(n log n).
TetMesh largest_part(const TetMesh& mesh);

}  // namespace palpate::anatomy
