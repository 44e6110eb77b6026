#pragma once

#include <cstdint>
#include <span>

#include "geometry/vector.hpp"

namespace palpate {

/// Which pairs of bodies can touch: two different ones of which at least one can move.
struct PairFilter {
  std::span<const std::uint8_t> immovable;  ///< per body
  [[nodiscard]] bool operator()(Index a, Index b) const {
    return a != b && (at(immovable, a) == 0 || at(immovable, b) == 0);
  }
};

}  // namespace palpate
