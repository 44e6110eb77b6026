#include "view/source.hpp"

#include <cmath>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "scene/body_colour.hpp"

namespace palpate::view {

using Json = nlohmann::ordered_json;

Json bodies_json(const Bodies& bodies, const Surface& surface, const Scene& scene) {
  Json list = Json::array();
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const Body& body = at(bodies.bodies(), b);
    const Range vertices = at(surface.body_vertices(), b);
    list.push_back({{"name", body.name},
                    {"vertices", {vertices.begin, vertices.end}},
                    {"triangles", {body.triangles.begin, body.triangles.end}},
                    {"points", body.points.size()},
                    {"tets", body.tets.size()},
                    {"rigid", is_rigid(at(scene.bodies, b))},
                    {"absent", at(scene.bodies, b).absent}});
    const SceneBody& of_scene = at(scene.bodies, b);
    // Colours on the page have 8 bits; a float as text would have digits without meaning.
    list.back()["color"] = Json::array();
    for (const float c : body_colour(of_scene, b)) list.back()["color"].push_back(std::round(1e4 * c) / 1e4);
  }
  return list;
}

namespace {

/// The views of the scene's pictures, in the form of the scene.
Json views_json(const Scene& scene) {
  const Json output = Json::parse(write_scene(scene)).value("output", Json::object());
  return output.value("views", Json::array());
}

}  // namespace

Json about_json(const Scene& scene, const Json& bodies, double diagonal) {
  Json json{
      {"name", scene.name},
      {"units", {{"length", scene.units.length}, {"mass", scene.units.mass}, {"time", scene.units.time}}},
      {"diagonal", diagonal},
      {"duration", scene.duration},
      {"time_step", scene.settings.time_step},
      {"settings", settings_json(scene.settings)},
      {"views", views_json(scene)},
      {"bodies", bodies}};
  if (scene.axes) json["axes"] = *scene.axes;
  return json;
}

Json detection_json(const DetectionCounts& counts) {
  return {{"contacts", counts.contacts},           {"border_edges", counts.border_edges},
          {"crossings", counts.crossings},         {"edge_contacts", counts.edge_contacts},
          {"candidates", counts.candidates},       {"movers", counts.movers},
          {"dropped_cells", counts.dropped_cells}, {"depth_fallbacks", counts.depth_fallbacks},
          {"cell_size", counts.cell_size}};
}

Extent extent_of(std::span<const Vec3> positions) {
  if (positions.empty()) return {{}, 0.0};
  Box box;
  for (const Vec3& p : positions) box.extend(p);
  return {0.5 * (box.lower + box.upper), length(box.upper - box.lower)};
}

}  // namespace palpate::view
