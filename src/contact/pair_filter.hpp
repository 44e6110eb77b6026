#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Which pairs of a point and a tet can touch: those of two bodies of which at least one can move, and those
/// of one body that can move and collides with itself, where the point is no corner of the tet.
struct PairFilter {
  std::span<const std::uint8_t> immovable;       ///< per body
  std::span<const std::uint8_t> self_collision;  ///< per body
  /// \param a  body of the point
  /// \param b  body of the tet
  [[nodiscard]] bool operator()(Index a, Index b, Index point, const Tet& tet) const {
    if (a != b) return at(immovable, a) == 0 || at(immovable, b) == 0;
    return at(self_collision, a) != 0 && at(immovable, a) == 0 &&
           std::find(tet.begin(), tet.end(), point) == tet.end();
  }
};

}  // namespace palpate
