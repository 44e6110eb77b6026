#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

namespace palpate::app {

/// Contacts between two bodies, or of a body with itself, on both sides; edge contacts included.
struct Overlap {
  Index first;   ///< body; <= second
  Index second;  ///< body
  std::size_t contacts = 0;
  double deepest = 0.0;
};

/// Each pair of bodies that has a contact in the last detection, sorted. O(contacts log pairs).
std::vector<Overlap> overlaps(const Bodies& bodies, const Detector& detector);

nlohmann::ordered_json overlaps_json(const Bodies& bodies, const std::vector<Overlap>& list);
/// A line for each of the deepest pairs, then the number of others; empty if there are no overlaps.
std::string overlaps_text(const Bodies& bodies, std::vector<Overlap> list, const std::string& length_unit);

}  // namespace palpate::app
