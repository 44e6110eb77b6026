#include "scene/load.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <palpate/error.hpp>

#include "geometry/rotation.hpp"
#include "geometry/vector.hpp"
#include "scene/body_mesh.hpp"
#include "scene/body_points.hpp"
#include "scene/cell_data.hpp"
#include "scene/fibre_fields.hpp"
#include "scene/json_text.hpp"
#include "scene/scene_motion.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

Vec3 place(const Transform& transform, const Quaternion& rotation, const Vec3& point) {
  const Vec3 scaled{transform.scale.x * point.x, transform.scale.y * point.y, transform.scale.z * point.z};
  return rotated(rotation, scaled) + transform.translate;
}

/// The label of each tet of a body; empty if no region asks for one.
std::vector<double> labels_of(const Scene& scene, Index body, Index tets, const CellReader& read_cells) {
  const std::vector<Region>& regions = at(scene.bodies, body).regions;
  const auto asks = std::ranges::find_if(
      regions, [](const Region& r) { return std::holds_alternative<LabelSelection>(r.tets); });
  if (asks == regions.end()) return {};
  const auto number = static_cast<std::size_t>(body);
  const auto region = static_cast<std::size_t>(asks - regions.begin());
  return cell_data_of(scene,
                      {.body = number,
                       .key = element_path(path_of(number) + ".regions", region) + ".label",
                       .name = "label",
                       .components = 1,
                       .tets = tets},
                      read_cells);
}

/// Gives the tets of a body's regions their materials.
void add_regions(const Scene& scene, Index body, const CellReader& read_cells, Model& model) {
  const SceneBody& scene_body = at(scene.bodies, body);
  const Range tets = at(model.bodies.bodies(), body).tets;
  const auto rest = model.bodies.points_rest();
  std::vector<Vec3> centers;
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    const Tet& t = at(model.bodies.tets(), tet);
    centers.push_back(0.25 * ((at(rest, t[0]) + at(rest, t[1])) + (at(rest, t[2]) + at(rest, t[3]))));
  }
  const std::vector<double> labels = labels_of(scene, body, tets.size(), read_cells);
  const Selector select{scene, model.bodies, body, centers, "tet", labels};
  for (std::size_t r = 0; r < scene_body.regions.size(); ++r) {
    const Region& region = scene_body.regions[r];
    const std::string path = path_of(static_cast<std::size_t>(body)) + ".regions[" + std::to_string(r) + "]";
    for (const Index tet : select(region.tets, path))
      at(model.material_of_tet, tets.begin + tet) = static_cast<Index>(model.materials.size());
    model.materials.push_back(region.material);
  }
}

/// If any body has a region, gives each tet its material.
void add_all_regions(const Scene& scene, const CellReader& read_cells, Model& model) {
  if (std::ranges::all_of(scene.bodies, [](const SceneBody& body) { return body.regions.empty(); })) return;
  for (Index body = 0; body < model.bodies.body_count(); ++body) {
    const auto end = static_cast<std::size_t>(at(model.bodies.bodies(), body).tets.end);
    model.material_of_tet.resize(end, body);
    add_regions(scene, body, read_cells, model);
  }
}

/// The material of rigid bodies without one: only its density matters, for their mass.
Material default_material(const Units& units) {
  Material material;
  material.young_modulus = from_si(material.young_modulus, units, dimension::pressure);
  material.density = from_si(material.density, units, dimension::density);
  return material;
}

}  // namespace

Vec3 transformed(const Transform& transform, const Vec3& point) {
  return place(transform, quaternion_of(transform.rotate), point);
}

void add_body(const Scene& scene, std::size_t b, TetMesh mesh, Model& model) {
  try {
    model.bodies.add(scene.bodies[b].name, std::move(mesh));
  } catch (const Error& error) {
    throw Error(scene.source, path_of(b) + " '" + error.source() + "', " + error.where(), error.found(),
                error.expected());
  }
}

Model load_model(const Scene& scene, const MeshReader& read_mesh, const CellReader& read_cells) {
  Model model;
  std::vector<Index> motions(scene.bodies.size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    TetMesh mesh = body_mesh(scene, b, read_mesh);
    const Quaternion rotation = quaternion_of(body.transform.rotate);
    for (Vec3& point : mesh.points) point = place(body.transform, rotation, point);
    add_body(scene, b, std::move(mesh), model);
    model.materials.push_back(body.material.value_or(default_material(scene.units)));
    model.obstacles.push_back(is_rigid(body) ? 1 : 0);
    if (body.absent) {
      model.absent.resize(scene.bodies.size(), 0);
      model.absent[b] = 1;
    }
    if (!body.motion) continue;
    motions[b] = static_cast<Index>(model.motions.size());
    model.motions.push_back(motion_of(*body.motion));
  }
  add_all_regions(scene, read_cells, model);
  add_fibre_fields(scene, read_cells, model);
  add_fibre_ends(scene, model);
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) fill_points(scene, b, motions, model);
  return model;
}

}  // namespace palpate
