#pragma once

#include <array>
#include <cstdint>

#include <palpate/mesh.hpp>

namespace palpate::bench {

/// A number in [0, 1) that depends on these three alone: the mix of SplitMix64 (Steele, Lea and Flood 2014).
double hashed_unit(std::uint64_t seed, std::uint64_t index, std::uint64_t channel);

/// Sine of the dihedral angle of a tet that is nearest to 0 or 180 degrees; negative where the volume is. 0
/// where a face is flat.
double flattest_sine(const std::array<Vec3, 4>& corners);

/// Moves the points inside a mesh so that it gets slivers: one point in four until a tet at it has a dihedral
/// angle of 0.2, 0.5, 1, 2 or 5 degrees (or 180 less that), the others 0.4 times as far as they could go. The
/// surface stays, each tet keeps a positive volume. Directions and angles by hashed_unit(), so that a seed
/// gives the same mesh everywhere. O(n_tets).
void make_slivers(TetMesh& mesh, std::uint64_t seed);

}  // namespace palpate::bench
