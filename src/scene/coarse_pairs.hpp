#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate {

/// Two bodies whose meshes are too coarse for each other: the edges of each are long relative to the
/// thickness of the other. So neither has points where the other is thin: they meet in a few points and
/// edges, and may pass each other within a step unseen.
struct CoarsePair {
  std::array<Index, 2> bodies{};
  std::array<double, 2> edges{};      ///< mean length of the surface edges of each at rest
  std::array<double, 2> thickness{};  ///< of each at rest; behind a tenth of its surface it is thinner
};

/// Pairs in which the edges of each are more than three times as long as the other is thick, the worst first.
/// O(surface triangles + pairs of bodies).
/// \param immovable  (n_bodies) 1: rigid; empty: none. Pairs of two of these are left out
std::vector<CoarsePair> coarse_pairs(const Bodies& bodies, std::span<const std::uint8_t> immovable);

}  // namespace palpate
