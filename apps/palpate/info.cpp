#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "body_report.hpp"
#include "exit_codes.hpp"
#include "geometry/vector.hpp"
#include "mesh_parts.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "overlaps.hpp"
#include "scene/first_scene.hpp"
#include "scene/json_text.hpp"
#include "size_warnings.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* info_examples = R"(Examples:
  palpate info liver.msh
  palpate info skull.vtu --unit mm
  palpate info scenes/stacking.json
  palpate info Ossicles.vtu --json | jq .edge_length.mean

Meshes: .vtu .vtk .msh .node .ele .mesh; scenes: .json.)";

struct InfoOptions {
  SceneChoice what;              ///< a scene, or a mesh, which has no changes
  std::optional<MeshUnit> unit;  ///< unit of a mesh's coordinates, if given
  bool json = false;
};

/// The longest side of the box around the points that tets use.
double longest_side(const MeshStatistics& statistics) {
  const Vec3 sides = statistics.upper - statistics.lower;
  return std::max({sides.x, sides.y, sides.z});
}

std::string size_text(const MeshUnit& unit, bool given, double side) {
  if (unit.name.empty()) return "";
  const std::string size = length_text(unit.meters * side) + " long\n";
  return given ? "size            " + size : fmt::format("likely unit     {}: {}", unit.name, size);
}

int mesh_info(const InfoOptions& options) {
  if (!options.what.changes.empty()) throw BadInput("--set", "", "a mesh", "a scene");
  MeshInput input = read_mesh_input(options.what.file);
  Bodies bodies;
  as_input([&] { return bodies.add(options.what.file.string(), std::move(input.mesh)); });
  const MeshStatistics statistics = mesh_statistics(bodies, bodies.points_rest());
  const MeshParts parts = mesh_parts(bodies, 0);
  const double side = longest_side(statistics);
  const MeshUnit unit = options.unit.value_or(guess_unit(side));
  if (options.unit) warn_of_size(input.record.file, side, *options.unit);
  if (options.json) {
    Json json{{"kind", "mesh"}};
    json.update(notes_json(&input.record, bodies.notes()[0]));
    json.update(statistics_json(statistics));
    json.update(parts_json(parts));
    json[options.unit ? "unit" : "likely_unit"] = unit.name.empty() ? Json() : Json(unit.name);
    print_out(format_json(json) + "\n");
    return exit_done;
  }
  const std::string notes = notes_text(&input.record, bodies.notes()[0]);
  print_out(fmt::format("{}: {}\n{}pieces          {}\n{}{}", input.record.file, input.record.format,
                        statistics_text(statistics, options.unit ? unit.name : ""), parts_text(parts),
                        size_text(unit, options.unit.has_value(), side),
                        notes.empty() ? "" : fmt::format("note            {}\n", notes)));
  print_note(fmt::format("next: {} shows it, {} makes a scene of it",
                         quoted_command("view", input.record.file),
                         quoted_command("new", input.record.file)));
  return exit_done;
}

/// The data that `info` prints about a scene.
struct SceneFacts {
  SceneInput input;
  Simulation simulation;  ///< at the start
  std::vector<std::uint8_t> obstacles;
  std::vector<std::uint8_t> fixed;       ///< (n_points)
  std::vector<std::uint8_t> fixed_axes;  ///< (n_points), or empty

  [[nodiscard]] Index fixed_points(Index body) const { return flags_of(body, fixed); }
  /// Number of points of a body that are fixed along some axes only.
  [[nodiscard]] Index sliding_points(Index body) const { return flags_of(body, fixed_axes); }
  /// Overlaps of all pairs of bodies, also of two rigid bodies. These exert no forces on each other in a run,
  /// but there is no room for tissue between them.
  [[nodiscard]] std::vector<Overlap> overlaps() const {
    const Bodies& bodies = simulation.bodies();
    Detector detector(bodies, simulation.settings().detection,
                      std::vector<std::uint8_t>(bodies.bodies().size(), 0));
    detector.detect(simulation.positions());
    return palpate::overlaps(bodies, detector);
  }
  [[nodiscard]] const MeshRecord* file(Index body) const {
    const auto& record = input.files[static_cast<std::size_t>(body)];
    return record ? &*record : nullptr;
  }

 private:
  /// Number of points of a body that have a flag.
  [[nodiscard]] Index flags_of(Index body, std::span<const std::uint8_t> flags) const {
    Index count = 0;
    const Range points = at(simulation.bodies().bodies(), body).points;
    for (Index p = points.begin; p < points.end && !flags.empty(); ++p) count += at(flags, p) != 0 ? 1 : 0;
    return count;
  }
};

Json scene_json(const SceneFacts& facts) {
  const Bodies& bodies = facts.simulation.bodies();
  const Scene& scene = facts.input.scene;
  const DetectionCounts& start = facts.simulation.detector().counts();
  Json json{
      {"kind", "scene"},
      {"file", utf8_text(scene.source)},
      {"name", scene.name},
      {"units", {{"length", scene.units.length}, {"mass", scene.units.mass}, {"time", scene.units.time}}},
      {"time_step", scene.settings.time_step},
      {"duration", scene.duration},
      {"cell_size", start.cell_size},
      {"contacts_at_start", start.contacts},
      {"edge_contacts_at_start", start.edge_contacts},
      {"unseen_pairs_at_start", start.unseen_pairs},
      {"overlaps_at_start", overlaps_json(bodies, facts.overlaps())},
      {"too_coarse", coarse_pairs_json(bodies, coarse_pairs(bodies, facts.obstacles))}};
  json["total"] = statistics_json(mesh_statistics(bodies, bodies.points_rest()));
  json["bodies"] = Json::array();
  for (Index b = 0; b < bodies.body_count(); ++b) {
    Json body{{"name", at(bodies.bodies(), b).name},
              {"obstacle", at(facts.obstacles, b) != 0},
              {"mass", at(facts.simulation.masses(), b)},
              {"fixed_points", facts.fixed_points(b)},
              {"points_with_fixed_axes", facts.sliding_points(b)}};
    body.update(statistics_json(mesh_statistics(bodies, bodies.points_rest(), b)));
    body.update(notes_json(facts.file(b), at(bodies.notes(), b)));
    json["bodies"].push_back(std::move(body));
  }
  return json;
}

/// Text on a body's constraints: "obstacle", "12 points fixed" or nothing.
std::string remark(const SceneFacts& facts, Index b) {
  if (at(facts.obstacles, b) != 0) return "  obstacle";
  std::string text;
  if (const Index fixed = facts.fixed_points(b); fixed > 0)
    text += fmt::format("  {} fixed", counted(static_cast<std::size_t>(fixed), "point"));
  if (const Index sliding = facts.sliding_points(b); sliding > 0)
    text += fmt::format("  {} with fixed axes", counted(static_cast<std::size_t>(sliding), "point"));
  return text;
}

std::string body_line(const SceneFacts& facts, Index b) {
  const Bodies& bodies = facts.simulation.bodies();
  const Body& body = at(bodies.bodies(), b);
  const bool obstacle = at(facts.obstacles, b) != 0;
  const std::string text =
      fmt::format("{:<20}{:>9}{:>9}{:>10}{:>9}{:>12}{}\n", shortened(body.name, 19), body.points.size(),
                  body.edges.size(), body.triangles.size(), body.tets.size(),
                  obstacle ? "-" : short_text(at(facts.simulation.masses(), b)), remark(facts, b));
  const std::string notes = notes_text(facts.file(b), at(bodies.notes(), b));
  return notes.empty() ? text : text + "  note: " + notes + "\n";
}

std::string scene_text(const SceneFacts& facts) {
  const Bodies& bodies = facts.simulation.bodies();
  const Scene& scene = facts.input.scene;
  const Units& units = scene.units;
  std::string text = fmt::format("{}: scene '{}' in {}, {}, {}\n", scene.source, shown_name(scene.name),
                                 units.length, units.mass, units.time);
  text += fmt::format("time step {} {}, duration {} {}\n\n", short_text(scene.settings.time_step), units.time,
                      short_text(scene.duration), units.time);
  text += fmt::format("{:<20}{:>9}{:>9}{:>10}{:>9}{:>12}\n", "body", "points", "edges", "triangles", "tets",
                      "mass [" + units.mass + "]");
  for (Index b = 0; b < bodies.body_count(); ++b) text += body_line(facts, b);
  text += "\nall bodies\n" + statistics_text(mesh_statistics(bodies, bodies.points_rest()), units.length);
  const DetectionCounts& start = facts.simulation.detector().counts();
  text += fmt::format("cell size       {} {}\n", short_text(start.cell_size), units.length);
  text += fmt::format("contacts        {} at the start, of points; {} of edges\n", start.contacts,
                      start.edge_contacts);
  if (start.unseen_pairs > 0) text += unseen_pairs_text(start.unseen_pairs) + "\n";
  text += overlaps_text(bodies, facts.overlaps(), units.length);
  return text + coarse_pairs_text(bodies, coarse_pairs(bodies, facts.obstacles), units.length);
}

int scene_info(const InfoOptions& options) {
  if (options.unit) throw BadInput("--unit", "", "a scene, which says its units", "a mesh");
  SceneInput input = read_scene_input(options.what);
  std::vector<std::uint8_t> obstacles = input.model.obstacles;
  std::vector<std::uint8_t> fixed = input.model.fixed_points;
  std::vector<std::uint8_t> fixed_axes = input.model.fixed_axes;
  Simulation simulation = make_simulation(input.scene, std::move(input.model), 0);
  const SceneFacts facts{std::move(input), std::move(simulation), std::move(obstacles), std::move(fixed),
                         std::move(fixed_axes)};
  print_out(options.json ? format_json(scene_json(facts)) + "\n" : scene_text(facts));
  return exit_done;
}

}  // namespace

Subcommand add_info(CLI::App& command) {
  CLI::App* app = command.add_subcommand("info", "print statistics of a mesh or scene");
  app->footer(info_examples);
  auto options = std::make_shared<InfoOptions>();
  add_path(*app, "FILE", options->what.file, "mesh or scene; '-': a scene from standard input");
  add_changes(*app, options->what.changes);
  add_value(*app, "--unit", "m|cm|mm|um", "unit of the numbers of a mesh; default: a guess, which is printed",
            [options](const std::string& flag, const std::string& text) {
              options->unit = parse_mesh_unit(flag, text);
            });
  add_json(*app, options->json, "print JSON");
  return {app,
          [options] { return is_scene(options->what.file) ? scene_info(*options) : mesh_info(*options); }};
}

}  // namespace palpate::app
