#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// Cell data of a mesh file that a key of a scene refers to.
struct CellDataOfBody {
  std::size_t body = 0;
  std::string key;   ///< path in the scene: "bodies[1].material.fibres.field"
  std::string name;  ///< of the array
  std::size_t components = 3;
  Index tets = 0;  ///< number of tets of the body
};

/// Reads the numbers of each tet (n_tets x components). Throws Error naming the scene, the key and the file
/// if the body has no mesh file, if the file has no such data, or if it has them for another number of tets.
/// O(file size).
std::vector<double> cell_data_of(const Scene& scene, const CellDataOfBody& wanted,
                                 const CellReader& read_cells);

}  // namespace palpate
