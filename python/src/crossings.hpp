#pragma once

#include <vector>

#include <palpate/detection.hpp>

namespace palpate::python {

/// Crossings of border edges (one end in contact, the other free) and the surface of the penetrated body.
/// Structure of arrays, sorted by (contact, edge, triangle).
struct Crossings {
  std::vector<Index> contact;     ///< (n) index into the contacts: the end in contact, and the body
  std::vector<Index> free_point;  ///< (n) the other end of the edge
  std::vector<Index> triangle;    ///< (n) the surface triangle, of World.triangles
  std::vector<double> parameter;  ///< (n) parameter on the edge: 0 at the point in contact, 1 at the free end
};

/// The crossings of a detector as arrays. O(crossings).
Crossings crossings_of(const Detector& detector);

}  // namespace palpate::python
