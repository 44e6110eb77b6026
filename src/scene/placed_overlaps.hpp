#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// Two bodies that overlap: one that a stage has placed, and a rigid body.
struct PlacedOverlap {
  Index placed = 0;
  Index other = 0;
  std::uint64_t contacts = 0;
  double deepest = 0.0;  ///< in the scene's unit of length
};

/// Finds bodies that stages have placed inside rigid ones, such as a plate in bone. No contact separates two
/// bodies that are both held.
class PlacedOverlaps {
 public:
  PlacedOverlaps(const Scene& scene, const Bodies& bodies);

  /// The pairs that overlap by more than 1 % of the smaller of their mean edge lengths, in the order of the
  /// bodies, without those that the scene lists in `no_contact`. Placed bodies have a motion, or a stage
  /// inserts them or moves them as a whole. Only bodies that are present and wholly prescribed count. Cost:
  /// one detection of these bodies.
  [[nodiscard]] std::vector<PlacedOverlap> find(const Simulation& simulation) const;

 private:
  std::vector<std::uint8_t> rigid_;   ///< (n_bodies) 1: rigid in the scene
  std::vector<std::uint8_t> placed_;  ///< (n_bodies)
  std::vector<std::array<Index, 2>> ignored_;
};

}  // namespace palpate
