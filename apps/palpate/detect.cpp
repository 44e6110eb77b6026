#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "detection_options.hpp"
#include "exit_codes.hpp"
#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "overlaps.hpp"
#include "run_report.hpp"
#include "scene_input.hpp"
#include "sim/holds.hpp"
#include "sim/prescribed_motions.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* detect_examples = R"(Examples:
  palpate detect scene.json > contacts.csv
  palpate detect scene.json --format json --out contacts.json
  palpate detect scene.json --structure brute | diff - contacts.csv

Points and tets are numbered over all bodies, in the order of the scene; all numbers begin at 0. Values have all their digits. CSV
lists the points that are inside a body. JSON also lists the edges that pass through a body with both ends outside (docs/edges.md).
With a budget (docs/budget.md), a note on stderr and JSON report what was not done.)";

constexpr std::array<std::string_view, 2> format_names{"csv", "json"};

struct DetectOptions {
  SceneChoice scene;
  std::size_t format = 0;  ///< index into format_names
  std::optional<std::filesystem::path> out;
  int threads = 0;
  DetectionOptions detection;
};

std::string csv(const Bodies& bodies, const Contacts& contacts) {
  std::string text =
      "point,point_body,body,tet,weight_0,weight_1,weight_2,weight_3,depth,direction_x,direction_y,direction_"
      "z\n";
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    text += fmt::format("{},{},{},{}", contacts.point[c], at(bodies.body_of_point(), contacts.point[c]),
                        contacts.body[c], contacts.tet[c]);
    const auto& w = contacts.weights[c];
    const Vec3& r = contacts.direction[c];
    for (const double value : {w[0], w[1], w[2], w[3], contacts.depth[c], r.x, r.y, r.z}) {
      text.append(1, ',').append(exact_text(value));
    }
    text += '\n';
  }
  return text;
}

Json contact_json(const Bodies& bodies, const Contacts& contacts, std::size_t c) {
  return {{"point", contacts.point[c]},
          {"point_body", at(bodies.body_of_point(), contacts.point[c])},
          {"body", contacts.body[c]},
          {"tet", contacts.tet[c]},
          {"weights", contacts.weights[c]},
          {"depth", contacts.depth[c]},
          {"direction", to_json(contacts.direction[c])}};
}

Json edge_contact_json(const Bodies& bodies, const EdgeContacts& contacts, std::size_t c) {
  const Edge& edge = at(bodies.edges(), contacts.edge[c]);
  const auto& [enters, leaves] = contacts.triangles[c];
  return {{"points", edge},
          {"point_body", bodies.body_of(edge)},
          {"body", contacts.body[c]},
          {"triangles", {at(bodies.triangles(), enters), at(bodies.triangles(), leaves)}},
          {"parameters", contacts.parameters[c]},
          {"depth", contacts.depth[c]},
          {"direction", to_json(contacts.direction[c])}};
}

/// One contact per line, so that tools that work on lines can be used.
std::string json(const Scene& scene, const Bodies& bodies, std::span<const std::uint8_t> obstacles,
                 const Detector& detector) {
  const Contacts& contacts = detector.contacts();
  Json list = Json::array();
  for (const Body& body : bodies.bodies()) {
    list.push_back({{"name", body.name},
                    {"points", {body.points.begin, body.points.end}},
                    {"tets", {body.tets.begin, body.tets.end}}});
  }
  std::string text =
      "{\n\"length_unit\": " + Json(scene.units.length).dump() + ",\n\"bodies\": " + list.dump();
  if (scene.settings.detection.budget) {
    text += ",\n\"completeness\": " + Json(detector.counts().completeness).dump() +
            ",\n\"late_bodies\": " + Json(late_body_names(bodies, detector)).dump();
  }
  if (scene.settings.detection.cells_per_primitive)
    text += ",\n\"dropped_cells\": " + Json(detector.counts().dropped_cells).dump();
  text += ",\n\"too_coarse\": " + coarse_pairs_json(bodies, coarse_pairs(bodies, obstacles)).dump();
  if (!scene.settings.detection.edge_contacts)
    text += ",\n\"unseen_pairs\": " + Json(detector.counts().unseen_pairs).dump();
  text += ",\n\"contacts\": [";
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    text += (c == 0 ? "\n" : ",\n") + contact_json(bodies, contacts, c).dump();
  }
  text += "\n],\n\"edge_contacts\": [";
  for (std::size_t c = 0; c < detector.edge_contacts().size(); ++c)
    text += (c == 0 ? "\n" : ",\n") + edge_contact_json(bodies, detector.edge_contacts(), c).dump();
  return text + "\n]\n}\n";
}

/// Throws BadInput if the output would replace the scene or one of its meshes.
void refuse_input_as_output(const DetectOptions& options, const SceneInput& input) {
  if (!options.out) return;
  std::vector<std::filesystem::path> files{options.scene.file};
  for (const std::optional<MeshRecord>& record : input.files)
    if (record) files.emplace_back(record->file);
  for (const std::filesystem::path& file : files) {
    std::error_code ignored;
    if (std::filesystem::equivalent(file, *options.out, ignored))
      throw BadInput("--out", "", options.out->string() + ", which is read", "another file");
  }
}

int detect(const DetectOptions& options) {
  SceneInput input = read_scene_input(options.scene);
  refuse_input_as_output(options, input);
  options.detection.apply(input.scene.settings.detection);
  // Positions at the start of a run: prescribed bodies are where their motion is at time 0.
  const Model& model = input.model;
  const Bodies& bodies = model.bodies;
  const Detector detector = as_input([&] {
    Detector made(bodies, without_absent(input.scene.settings.detection, model.absent), model.obstacles,
                  options.threads);
    PrescribedMotions prescribed(model.motions, model.motion_of_point, bodies.points_rest());
    made.detect(prescribed.start_positions(parallel::Threads(options.threads), bodies.points_rest()));
    return made;
  });
  const Contacts& contacts = detector.contacts();
  const std::string text = format_names[options.format] == "csv"
                               ? csv(bodies, contacts)
                               : json(input.scene, bodies, model.obstacles, detector);
  if (options.out) {
    io::write_atomically(*options.out, text);
  } else {
    print_out(text);
  }
  const DetectionCounts& counts = detector.counts();
  const std::string edges =
      counts.edge_contacts > 0 ? counted(counts.edge_contacts, "edge contact") + ", " : "";
  print_note(fmt::format("{}, {}{}, {}, {} tested", counted(counts.contacts, "contact"), edges,
                         counted(counts.border_edges, "border edge"), counted(counts.crossings, "crossing"),
                         counted(counts.candidates, "candidate")));
  const std::string coarse =
      coarse_pairs_text(bodies, coarse_pairs(bodies, model.obstacles), input.scene.units.length);
  std::istringstream lines(coarse);
  for (std::string line; std::getline(lines, line);) print_note(line);
  if (counts.unseen_pairs > 0) print_note(unseen_pairs_text(counts.unseen_pairs));
  if (counts.late_clusters > 0) {
    print_note(fmt::format("the budget was too small: {} % of the work done, contacts may be missing in {}",
                           short_text(100.0 * counts.completeness), late_bodies_text(bodies, detector)));
  }
  if (counts.dropped_cells > 0) {
    print_note(fmt::format("the limit of cells per primitive left out {}: contacts may be missing",
                           counted(counts.dropped_cells, "cell")));
  }
  return exit_done;
}

}  // namespace

Subcommand add_detect(CLI::App& command) {
  CLI::App* app = command.add_subcommand("detect", "contacts at the start of a scene, as CSV or JSON");
  app->footer(detect_examples);
  auto options = std::make_shared<DetectOptions>();
  add_path(*app, "SCENE", options->scene.file, "scene file (.json), '-' for standard input");
  add_changes(*app, options->scene.changes);
  add_value(*app, "--format", "csv|json", "format of the output; default: csv",
            [options = options.get()](const std::string& flag, const std::string& text) {
              options->format = parse_choice(flag, text, format_names);
            });
  add_value(*app, "--out", "FILE", "file to write, instead of stdout",
            [options = options.get()](const std::string&, const std::string& text) { options->out = text; });
  add_threads(*app, options->threads);
  add_detection_options(*app, options->detection);
  return {app, [options] { return detect(*options); }};
}

}  // namespace palpate::app
