#pragma once

#include <palpate/mesh.hpp>

namespace palpate::anatomy {

/// Rounds coordinates to multiples of 2^-20: libraries whose sines differ in the last bit give the same mesh,
/// and files compress better. O(n).
void round_points(TetMesh& mesh);

}  // namespace palpate::anatomy
