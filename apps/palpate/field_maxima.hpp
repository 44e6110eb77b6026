#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/field_values.hpp"

namespace palpate::app {

/// The largest value of a field (of vectors: their length) over the frames of a run, and its position.
struct FieldMaximum {
  std::string name;
  double value = 0.0;
  std::int64_t step = -1;  ///< -1: no frame yet
  Index body = -1;
  Index item = -1;       ///< index among the body's own tets, or its own points for fields at points
  bool of_tets = false;  ///< whether `item` is a tet
  Vec3 place{};          ///< position of the point, or of the centre of the tet
};

/// Updates the maxima with a frame, for fields of one to three components. NaN is ignored. O(values).
void raise_maxima(const Simulation& simulation, const FieldArrays& fields, std::vector<FieldMaximum>& maxima);

}  // namespace palpate::app
