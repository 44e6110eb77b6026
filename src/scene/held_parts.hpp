#pragma once

#include <cstdint>
#include <vector>

#include <palpate/mesh.hpp>

#include "scene/parts.hpp"

namespace palpate {

/// The parts by which a body is held: its lowest tenth, and the lowest tenth of each further piece.
struct HeldParts {
  std::vector<BoxSelection> boxes;
  std::vector<std::uint8_t> points;  ///< (n_points) 1: held, or in a piece without a held point
};

/// Finds these parts for one body (z is up). A piece, connected by edges, that does not reach into the lowest
/// tenth of the body would fall. So it is held, too, but only the 20 largest such pieces are (by their number
/// of points). O(n log n).
HeldParts held_parts(const Bodies& body);

}  // namespace palpate
