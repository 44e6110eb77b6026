#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unistd.h>
#include <utility>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "messages.hpp"
#include "new_scene.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "scene_input.hpp"
#include "size_warnings.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate new liver.vtu                         writes liver.json: the liver is held, and an instrument presses it
  palpate new liver.vtu --unit mm --drop        it falls onto a floor
  palpate new ball.msh --size 0.08 --out trial.json && palpate view trial.json

Mesh files do not say what their numbers are in. Without --unit and --size the unit is guessed by the longest side, and
asked for on a terminal. The scene is in m, kg and s, ready to be changed: docs/scene.md explains it.)";

struct NewOptions {
  NewSceneRequest request;
  std::optional<fs::path> out;
  bool yes = false;
};

fs::path scene_path(const NewOptions& options) {
  fs::path path = options.out.value_or(options.request.mesh.stem().string() + ".json");
  std::error_code ignored;
  if (!options.out && fs::exists(path, ignored))
    throw BadInput(path.string(), "", "a file of that name already", "--out SCENE, which may replace it");
  if (path.extension() != ".json")
    throw BadInput("--out", "", "'" + path.string() + "'", "a name that ends in .json");
  const fs::path folder = path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    throw BadInput("--out", "", "no folder '" + folder.string() + "'", "one that is there");
  return path;
}

/// Takes an answer of the user into the request: a unit, or a length such as "0.3"; empty leaves the guess.
void take_answer(const std::string& answer, NewSceneRequest& request) {
  if (answer.empty()) return;
  request.unit = mesh_unit(answer);
  if (request.unit) return;
  try {
    request.longest = parse_number("the answer", answer, scene_format::above(0.0));
  } catch (const BadInput&) {
    throw BadInput("the answer", "", "'" + answer + "'",
                   "m, cm, mm, um, or the length of the longest side in metres");
  }
}

/// A line of the user; none at the end of the input.
std::optional<std::string> read_line() {
  std::string line;
  for (int c = std::getchar(); c != '\n'; c = std::getchar()) {
    if (c == EOF) return std::nullopt;
    line += static_cast<char>(c);
  }
  return line;
}

/// Asks which unit is meant, where somebody is there to answer.
NewScene made_as_agreed(NewSceneRequest request, bool yes) {
  NewScene made = new_scene_of(request);
  const bool asks = !yes && !request.unit && !request.longest && ::isatty(STDIN_FILENO) == 1 &&
                    ::isatty(STDERR_FILENO) == 1;
  if (!asks) return made;
  const Vec3& size = made.first.size;
  const std::string guess =
      made.unit.name.empty() ? "no unit fits; scaled it is" : fmt::format("in {} that is", made.unit.name);
  say_note(
      fmt::format("{} is {} long: {} {} and {}. Enter: so be it; or m, cm, mm, um, or a length in metres:",
                  request.mesh.string(), short_text(made.longest_side), guess,
                  length_text(std::max({size.x, size.y, size.z})), mass_text(made.first.mass)));
  const auto answer = read_line();
  if (!answer) throw BadInput("the answer", "", "the end of the input", "a unit, a length or an empty line");
  take_answer(*answer, request);
  return answer->empty() ? made : new_scene_of(request);
}

int write_new(const NewOptions& options) {
  const fs::path path = scene_path(options);
  NewSceneRequest request = options.request;
  request.folder = path.parent_path();
  const NewScene made = made_as_agreed(std::move(request), options.yes);
  Scene written = made.first.scene;
  written.name = path.stem().string();  // results go to a folder of this name
  written.source = path.string();
  load_scene_input(written);  // as 'run' will: what it refuses or warns of is told now
  io::write_atomically(path, write_scene(written));
  print_out(fmt::format("{}: {}\n", path.string(), description_of(made)));
  say_note(
      fmt::format("next: 'palpate view {0}' shows it and lets you pull at it, 'palpate run {0}' simulates it",
                  path.string()));
  return exit_done;
}

void add_flags(CLI::App& app, NewOptions& options) {
  add_path(app, "MESH", options.request.mesh, "mesh of tets: .vtu .vtk .msh .node .ele .mesh");
  add_value(app, "--out", "SCENE",
            "file to write; default: the name of the mesh, .json, in the current folder",
            [&options](const std::string&, const std::string& text) { options.out = text; });
  CLI::Option* const unit = add_value(app, "--unit", "m|cm|mm|um",
                                      "what the numbers of the mesh are in; default: guessed by its size",
                                      [&options](const std::string& flag, const std::string& text) {
                                        options.request.unit = parse_mesh_unit(flag, text);
                                      });
  add_value(app, "--size", "METRES", "length of its longest side, in place of a unit",
            [&options](const std::string& flag, const std::string& text) {
              options.request.longest = parse_number(flag, text, scene_format::above(0.0));
            })
      ->excludes(unit);
  app.add_flag("--drop", options.request.drop,
               "let it fall onto a floor, in place of holding its lowest tenth");
  app.add_flag("--yes", options.yes, "take the guess, do not ask");
}

}  // namespace

Subcommand add_new(CLI::App& command) {
  CLI::App* app = command.add_subcommand("new", "write a scene around a mesh, to start from");
  app->footer(examples);
  auto options = std::make_shared<NewOptions>();
  add_flags(*app, *options);
  return {app, [options] { return write_new(*options); }};
}

}  // namespace palpate::app
