#pragma once

#include <cstdint>
#include <vector>

#include <palpate/mesh.hpp>

#include "scene/parts.hpp"

namespace palpate {

/// The parts of a body that hold it: its lowest tenth, and the lowest tenth of each further piece.
struct HeldParts {
  std::vector<BoxSelection> boxes;
  std::vector<std::uint8_t> points;  ///< (n_points) 1: held, or of a piece that nothing holds
};

/// Finds them for one body (z upwards). A piece, connected by edges, that does not reach into the lowest
/// tenth of the body would fall, so it is held too; but only the 20 largest such pieces, by their points. O(n
/// log n).
HeldParts held_parts(const Bodies& body);

}  // namespace palpate
