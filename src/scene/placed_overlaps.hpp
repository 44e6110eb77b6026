#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// A body that a plan puts somewhere, and a rigid body that is there already.
struct PlacedOverlap {
  Index placed = 0;
  Index other = 0;
  std::uint64_t contacts = 0;
  double deepest = 0.0;  ///< in the scene's unit of length
};

/// Finds bodies that stages put into rigid ones, as a plate into bone: no contact keeps two bodies apart that
/// are both held.
class PlacedOverlaps {
 public:
  PlacedOverlaps(const Scene& scene, const Bodies& bodies);

  /// The pairs that overlap by more than 1 % of the smaller mean edge length of the two, in the order of the
  /// bodies. A body counts as placed where it has a motion, or a stage inserts it or moves all of it; and
  /// only while it is there and held whole. O(a detection of these bodies).
  [[nodiscard]] std::vector<PlacedOverlap> find(const Simulation& simulation) const;

 private:
  std::vector<std::uint8_t> rigid_;   ///< (n_bodies) in the scene
  std::vector<std::uint8_t> placed_;  ///< (n_bodies)
};

}  // namespace palpate
