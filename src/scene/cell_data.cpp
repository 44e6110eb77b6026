#include "scene/cell_data.hpp"

#include <variant>

#include <palpate/error.hpp>

namespace palpate {

std::vector<double> cell_data_of(const Scene& scene, const CellDataOfBody& wanted,
                                 const CellReader& read_cells) {
  const auto* const file = std::get_if<MeshFile>(&scene.bodies[wanted.body].source);
  if (file == nullptr)
    throw Error(scene.source, wanted.key, "this key in a body without a mesh file", "a body with 'mesh'");
  if (!read_cells) {
    throw Error(scene.source, wanted.key, "no function to read cell data with",
                "one (the argument read_cells)");
  }
  std::vector<double> data;
  try {
    data = read_cells(scene.folder / file->path, wanted.name, wanted.components);
  } catch (const Error& error) {
    throw Error(scene.source,
                wanted.key + ", " + error.source() + (error.where().empty() ? "" : ", " + error.where()),
                error.found(), error.expected());
  }
  const std::size_t rows = data.size() / wanted.components;
  if (rows != static_cast<std::size_t>(wanted.tets)) {
    throw Error(scene.source, wanted.key,
                std::to_string(rows) + (wanted.components == 1 ? " numbers" : " vectors"),
                std::to_string(wanted.tets) + ", one a tet");
  }
  return data;
}

}  // namespace palpate
