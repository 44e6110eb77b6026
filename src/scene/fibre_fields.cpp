#include "scene/fibre_fields.hpp"

#include <string>
#include <variant>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/json_text.hpp"

namespace palpate {
namespace {

std::vector<Vec3> read_field(const Scene& scene, std::size_t body, const std::string& path,
                             const std::string& name, const VectorReader& read_vectors) {
  const auto* const file = std::get_if<MeshFile>(&scene.bodies[body].source);
  const std::string key = path + ".fibres.field";
  if (file == nullptr) throw Error(scene.source, key, "it in a body without a mesh file", "one with 'mesh'");
  if (!read_vectors) throw Error(scene.source, key, "nobody who reads it", "a reader of vectors");
  try {
    return read_vectors(scene.folder / file->path, name);
  } catch (const Error& error) {
    throw Error(scene.source,
                key + ", " + error.source() + (error.where().empty() ? "" : ", " + error.where()),
                error.found(), error.expected());
  }
}

/// Of the tets of one body that are of one material.
void add_field(const Scene& scene, std::size_t body, const std::string& path, Index material,
               const VectorReader& read_vectors, Model& model) {
  const std::string name = at(model.materials, material).fibres.field;
  if (name.empty()) return;
  const std::vector<Vec3> field = read_field(scene, body, path, name, read_vectors);
  const Range tets = model.bodies.bodies()[body].tets;
  if (field.size() != static_cast<std::size_t>(tets.size())) {
    throw Error(scene.source, path + ".fibres.field", std::to_string(field.size()) + " vectors",
                std::to_string(tets.size()) + ", one a tet");
  }
  model.fibre_of_tet.resize(model.bodies.tets().size());
  Transform rotation = scene.bodies[body].transform;
  rotation.translate = {};
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    const Index own =
        model.material_of_tet.empty() ? static_cast<Index>(body) : at(model.material_of_tet, tet);
    if (own == material) at(model.fibre_of_tet, tet) = transformed(rotation, at(field, tet - tets.begin));
  }
}

}  // namespace

void add_fibre_fields(const Scene& scene, const VectorReader& read_vectors, Model& model) {
  auto next = static_cast<Index>(scene.bodies.size());  // materials of regions follow those of bodies
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const std::string path = element_path("bodies", b);
    add_field(scene, b, path + ".material", static_cast<Index>(b), read_vectors, model);
    for (std::size_t r = 0; r < scene.bodies[b].regions.size(); ++r)
      add_field(scene, b, element_path(path + ".regions", r) + ".material", next++, read_vectors, model);
  }
}

}  // namespace palpate
