#pragma once

#include <nlohmann/json.hpp>

#include <palpate/simulation.hpp>

namespace palpate::app {

/// How far the points of a body are from their rest positions, as the frames have it for each.
struct Displacement {
  Vec3 mean;                 ///< over the points
  double mean_length = 0.0;  ///< over the points
  double largest = 0.0;
};
Displacement displacement_of(const Simulation& simulation, Index body);

/// Tets of a body that are flat or inside out.
Index inverted_tets(const Simulation& simulation, Index body);

nlohmann::ordered_json displacement_json(const Displacement& displacement);

}  // namespace palpate::app
