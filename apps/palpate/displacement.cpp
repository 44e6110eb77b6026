#include "displacement.hpp"

#include <algorithm>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "mesh/unused_points.hpp"
#include "numbers.hpp"

namespace palpate::app {

Displacement displacement_of(const Simulation& simulation, Index body) {
  const Range points = at(simulation.bodies().bodies(), body).points;
  Displacement result;
  Index count = 0;
  for (Index p = points.begin; p < points.end; ++p) {
    if (is_unused(simulation.bodies(), p)) continue;
    ++count;
    const Vec3 moved = at(simulation.positions(), p) - at(simulation.bodies().points_rest(), p);
    result.mean += moved;
    result.mean_length += length(moved);
    result.largest = std::max(result.largest, length(moved));
  }
  const double scale = count > 0 ? 1.0 / count : 0.0;
  result.mean = scale * result.mean;
  result.mean_length *= scale;
  return result;
}

Index inverted_tets(const Simulation& simulation, Index body) {
  const Range tets = at(simulation.bodies().bodies(), body).tets;
  Index count = 0;
  for (Index t = tets.begin; t < tets.end; ++t) {
    const Tet& tet = at(simulation.bodies().tets(), t);
    const auto corner = [&](std::size_t i) { return at(simulation.positions(), tet[i]); };
    if (orient3d(corner(0), corner(1), corner(2), corner(3)) <= 0) ++count;
  }
  return count;
}

nlohmann::ordered_json displacement_json(const Displacement& displacement) {
  return {{"mean", to_json(displacement.mean)},
          {"mean_length", displacement.mean_length},
          {"largest", displacement.largest}};
}

}  // namespace palpate::app
