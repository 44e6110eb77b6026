#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "messages.hpp"
#include "new_scene.hpp"
#include "new_scene_flags.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "scene_input.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* new_examples = R"(Examples:
  palpate new liver.vtu                         writes liver.json: the liver is held, and an instrument presses it
  palpate new liver.vtu --unit mm --drop        it falls onto a floor, and then a plate presses it
  palpate new ball.msh --size 0.08 --out trial.json && palpate view trial.json

Mesh files have no unit. Without --unit and --size the unit is guessed from the longest side; on a terminal you are asked
to confirm it. The scene is in m, kg and s. docs/scene.md explains its keys. Its young_modulus is 20 kPa, or more if the
body would sag by over 1/200 of its height: replace it by that of the tissue.)";

struct NewOptions {
  NewSceneFlags mesh;
  std::optional<fs::path> out;
  bool replace = false;
};

/// Throws BadInput if a scene is given instead of a mesh.
void refuse_scene(const fs::path& path) {
  std::error_code ignored;
  if (path.extension() != ".json" || !fs::exists(path, ignored)) return;
  const std::string file = path.string();
  throw BadInput(file, "", "a file that is a scene already",
                 fmt::format("a mesh of tets; {} shows the scene, {} simulates it",
                             quoted_command("view", file), quoted_command("run", file)));
}

fs::path scene_path(const NewOptions& options) {
  refuse_scene(options.mesh.request.mesh);
  fs::path path = options.out.value_or(options.mesh.request.mesh.stem().string() + ".json");
  std::error_code ignored;
  if (path.extension() != ".json")
    throw BadInput("--out", "", "'" + path.string() + "'", "a name that ends in .json");
  const fs::path folder = path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    throw BadInput("--out", "", "no folder '" + folder.string() + "'", "an existing folder");
  if (!options.replace && fs::exists(path, ignored)) {
    throw BadInput(path.string(), "", "an existing file",
                   "a new name (--out), or --replace to write over the file");
  }
  return path;
}

int write_new(const NewOptions& options) {
  const fs::path path = scene_path(options);
  NewSceneFlags mesh = options.mesh;
  mesh.request.folder = path.parent_path();
  const NewScene made = new_scene_as_agreed(mesh);
  Scene written = made.first.scene;
  written.name = path.stem().string();  // results are written to a folder with this name
  written.source = path.string();
  load_scene_input(written);  // reads it as 'run' will, so that errors and warnings appear now
  io::write_atomically(path, write_brief_scene(written));
  print_out(fmt::format("{}: {}\n", path.string(), description_of(made)));
  print_note(stiffness_of(made));
  print_note(fmt::format("next: {} shows it and lets you pull at it, {} simulates it",
                         quoted_command("view", path.string()), quoted_command("run", path.string())));
  return exit_done;
}

void add_flags(CLI::App& app, NewOptions& options) {
  add_path(app, "MESH", options.mesh.request.mesh, "mesh of tets: .vtu .vtk .msh .node .ele .mesh");
  add_value(app, "--out", "SCENE",
            "file to write; default: NAME.json in the current folder, by the name of the mesh",
            [&options](const std::string&, const std::string& text) { options.out = text; });
  add_new_scene_flags(app, options.mesh);
  app.add_flag("--replace", options.replace, "replace an existing scene");
}

}  // namespace

Subcommand add_new(CLI::App& command) {
  CLI::App* app = command.add_subcommand("new", "write a scene that contains a mesh, as a first version");
  app->footer(new_examples);
  auto options = std::make_shared<NewOptions>();
  add_flags(*app, *options);
  return {app, [options] { return write_new(*options); }};
}

}  // namespace palpate::app
