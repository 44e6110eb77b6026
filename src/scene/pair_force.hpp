#pragma once

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Contact force on a body by another body in the last step, N. O(contacts log).
inline Vec3 force_by(const Simulation& simulation, Index on, Index by) {
  for (const PairWrench& pair : simulation.pair_wrenches()) {
    if (pair.body_a == by && pair.body_b == on) return pair.on_b.force;
    if (pair.body_a == on && pair.body_b == by) return -1.0 * pair.on_b.force;
  }
  return {};
}

}  // namespace palpate
