#pragma once

#include <nlohmann/json.hpp>

#include <palpate/simulation.hpp>

namespace palpate::app {

/// Displacement of the points of a body from their rest positions, like the field `displacement` of frames.
struct Displacement {
  Vec3 mean;                 ///< mean over the points
  double mean_length = 0.0;  ///< mean length over the points
  double largest = 0.0;
};
Displacement displacement_of(const Simulation& simulation, Index body);

/// Number of flat or inverted tets of a body.
Index inverted_tets(const Simulation& simulation, Index body);

nlohmann::ordered_json displacement_json(const Displacement& displacement);

}  // namespace palpate::app
