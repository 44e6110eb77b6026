#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Which pairs of a point and a tet may touch: pairs of two bodies that are not ignored and of which at least
/// one can move, unless a tie holds them together; and pairs within one movable body with self-collision, if
/// the point is not a corner of the tet.
struct PairFilter {
  std::span<const std::uint8_t> immovable;       ///< per body
  std::span<const std::uint8_t> self_collision;  ///< per body
  std::span<const std::array<Index, 2>> ignored_pairs =
      {};  ///< ascending, with the lower body first in each pair

  std::span<const std::array<Index, 2>> tied_points = {};  ///< point, body to which it is tied; ascending
  std::span<const std::array<Index, 2>> tied_bodies = {};  ///< bodies of these ties, as `ignored_pairs`

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
  /// Whether any point of one of these two different bodies is tied to the other. O(log tied_bodies).
  [[nodiscard]] bool ties(Index a, Index b) const {
    return !tied_bodies.empty() &&
           std::ranges::binary_search(tied_bodies, std::array{std::min(a, b), std::max(a, b)});
  }
  /// Whether a tie holds two primitives of different bodies together, so that they do not touch: a point of
  /// one is tied to the body of the other. The filter above does not ask this, since few pairs are contacts.
  /// O(log tied_points).
  template <class A, class B>
  [[nodiscard]] bool are_tied(Index a, const A& points_a, Index b, const B& points_b) const {
    if (!ties(a, b)) return false;
    const auto any_is_tied = [&](const auto& points, Index body) {
      return std::ranges::any_of(points, [&](Index p) {
        return std::ranges::binary_search(tied_points, std::array{p, body});
      });
    };
    return any_is_tied(points_a, b) || any_is_tied(points_b, a);
  }
};

}  // namespace palpate
