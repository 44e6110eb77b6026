#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/field_values.hpp"

namespace palpate::app {

/// The largest value of a field, or length of its vectors, over the frames of a run, and where it was.
struct FieldMaximum {
  std::string name;
  double value = 0.0;
  std::int64_t step = -1;  ///< none yet
  Index body = -1;
  Index item = -1;       ///< of the body's own tets, or points where the field has none for tets
  bool of_tets = false;  ///< what `item` is
  Vec3 place{};          ///< of the point, or the centre of the tet
};

/// Raises the maxima by a frame: of numbers and vectors (one to three components).
/// Values that are not numbers do not count. O(values).
void raise_maxima(const Simulation& simulation, const FieldArrays& fields, std::vector<FieldMaximum>& maxima);

}  // namespace palpate::app
