#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Which pairs of a point and a tet may touch: pairs of two bodies that are not ignored and of which at least
/// one can move; and pairs within one movable body with self-collision, if the point is not a corner of the
/// tet.
struct PairFilter {
  std::span<const std::uint8_t> immovable;       ///< per body
  std::span<const std::uint8_t> self_collision;  ///< per body
  std::span<const std::array<Index, 2>> ignored_pairs =
      {};  ///< ascending, with the lower body first in each pair

  /// Whether contacts of these two different bodies are ignored. O(log ignored_pairs).
  [[nodiscard]] bool ignores(Index a, Index b) const {
    return !ignored_pairs.empty() && std::binary_search(ignored_pairs.begin(), ignored_pairs.end(),
                                                        std::array{std::min(a, b), std::max(a, b)});
  }
  /// Whether two different bodies can touch. O(log ignored_pairs).
  [[nodiscard]] bool bodies(Index a, Index b) const {
    return (at(immovable, a) == 0 || at(immovable, b) == 0) && !ignores(a, b);
  }
  /// Whether a body can touch itself.
  [[nodiscard]] bool itself(Index body) const {
    return !self_collision.empty() && at(self_collision, body) != 0 && at(immovable, body) == 0;
  }
  /// \param a  body of the point
  /// \param b  body of the tet
  [[nodiscard]] bool operator()(Index a, Index b, Index point, const Tet& tet) const {
    if (a != b) return bodies(a, b);
    return itself(a) && std::find(tet.begin(), tet.end(), point) == tet.end();
  }
};

}  // namespace palpate
