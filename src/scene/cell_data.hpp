#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// Cell data of the mesh file of a body, as a key of a scene asks for them.
struct CellDataOfBody {
  std::size_t body = 0;
  std::string key;   ///< path in the scene: "bodies[1].material.fibres.field"
  std::string name;  ///< of the array
  std::size_t components = 3;
  Index tets = 0;  ///< of the body
};

/// The numbers of each tet (n_tets x components). Throws Error naming the scene, the key and the file where
/// the body has no mesh file, its file no such data, or another number of tets. O(file size).
std::vector<double> cell_data_of(const Scene& scene, const CellDataOfBody& wanted,
                                 const CellReader& read_cells);

}  // namespace palpate
