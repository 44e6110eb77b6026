#pragma once

#include <cstdint>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

namespace palpate {

/// The contacts between two bodies, or of a body with itself, in both directions; edge contacts included.
struct Overlap {
  Index first = 0;   ///< a body; first <= second
  Index second = 0;  ///< body
  std::uint64_t contacts = 0;
  double deepest = 0.0;  ///< in the unit of length of the positions
};

/// Each pair of bodies that has a contact in the last detection, sorted. O(contacts log pairs).
std::vector<Overlap> overlaps(const Bodies& bodies, const Detector& detector);

}  // namespace palpate
