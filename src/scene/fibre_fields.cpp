#include "scene/fibre_fields.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/fibres.hpp>

#include "geometry/vector.hpp"
#include "scene/cell_data.hpp"
#include "scene/json_text.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

/// Sets the fibres of those tets of one body that have one material.
void add_field(const Scene& scene, std::size_t body, const std::string& path, Index material,
               const CellReader& read_cells, Model& model) {
  const std::string name = at(model.materials, material).fibres.field;
  if (name.empty()) return;
  const Range tets = model.bodies.bodies()[body].tets;
  constexpr std::size_t dimensions = 3;
  const std::vector<double> field = cell_data_of(scene,
                                                 {.body = body,
                                                  .key = path + ".fibres.field",
                                                  .name = name,
                                                  .components = dimensions,
                                                  .tets = tets.size()},
                                                 read_cells);
  model.fibre_of_tet.resize(model.bodies.tets().size());
  Transform rotation = scene.bodies[body].transform;
  rotation.translate = {};
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    const Index own =
        model.material_of_tet.empty() ? static_cast<Index>(body) : at(model.material_of_tet, tet);
    if (own != material) continue;
    const double* const row = field.data() + dimensions * static_cast<std::size_t>(tet - tets.begin);
    at(model.fibre_of_tet, tet) = transformed(rotation, {row[0], row[1], row[2]});
  }
}

void add_ends(const Scene& scene, std::size_t b, const FibreEnds& ends, Model& model) {
  const Body& body = model.bodies.bodies()[b];
  const auto index = static_cast<Index>(b);
  const Selector select{scene, model.bodies, index,
                        model.bodies.points_rest().subspan(static_cast<std::size_t>(body.points.begin),
                                                           static_cast<std::size_t>(body.points.size())),
                        "point"};
  const std::string path = element_path("bodies", b) + ".fibre_ends";
  const std::vector<Index> from = select(ends.from, path + ".from");
  const std::vector<Index> to = select(ends.to, path + ".to");
  model.fibre_of_tet.resize(model.bodies.tets().size());
  try {
    std::ranges::copy(fibres_between(model.bodies, index, from, to),
                      model.fibre_of_tet.begin() + body.tets.begin);
  } catch (const Error& error) {
    throw Error(scene.source, path + "." + error.where(), error.found(), error.expected());
  }
}

}  // namespace

void add_fibre_ends(const Scene& scene, Model& model) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (scene.bodies[b].fibre_ends) add_ends(scene, b, *scene.bodies[b].fibre_ends, model);
}

void add_fibre_fields(const Scene& scene, const CellReader& read_cells, Model& model) {
  auto next = static_cast<Index>(scene.bodies.size());  // materials of regions follow those of bodies
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const std::string path = element_path("bodies", b);
    add_field(scene, b, path + ".material", static_cast<Index>(b), read_cells, model);
    for (std::size_t r = 0; r < scene.bodies[b].regions.size(); ++r)
      add_field(scene, b, element_path(path + ".regions", r) + ".material", next++, read_cells, model);
  }
}

}  // namespace palpate
