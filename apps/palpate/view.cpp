#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "messages.hpp"
#include "new_scene.hpp"
#include "new_scene_flags.hpp"
#include "numbers.hpp"
#include "open_browser.hpp"
#include "option_values.hpp"
#include "relax_model.hpp"
#include "scene_input.hpp"
#include "subcommands.hpp"
#include "view/gate.hpp"
#include "view/live.hpp"
#include "view/page.hpp"
#include "view/replay.hpp"
#include "view/server.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* view_examples = R"(Examples:
  palpate view scenes/stacking.json              run a scene and show it in the browser
  palpate view liver.vtu                         a mesh: fixed at its base, pressed by an instrument
  palpate view liver.vtu --unit mm --drop        a mesh in mm: it falls onto a floor
  palpate view results/stacking                  show the results of a run
  palpate view scene.json --port 8080 --no-browser --speed max

The page is served on this machine only, at an address with a random token. Ctrl-C ends the server. For a remote
machine: ssh -L 8080:127.0.0.1:8080 HOST, then palpate view scene.json --port 8080 there.
PALPATE_VIEW_TOKEN sets the token, so that open pages find the server again after a restart.)";

struct ViewOptions {
  SceneChoice what;    ///< a scene, a mesh, or the folder of a run
  NewSceneFlags mesh;  ///< of a mesh
  view::ServerSettings server;
  view::PlayerSettings player{.playing = true, .alone = false, .speed = 1.0};
  bool no_browser = false;
  bool json = false;
  int threads = 0;
};

std::string token() {
  const char* given = std::getenv("PALPATE_VIEW_TOKEN");
  if (given == nullptr || *given == '\0') return view::random_token();
  if (view::is_token(given)) return given;
  throw BadInput("PALPATE_VIEW_TOKEN", "", fmt::format("{} characters", std::string_view(given).size()),
                 "16 to 128 letters, digits, '-' and '_'");
}

/// Loads the scene to show. For a mesh, makes a scene.
SceneInput scene_to_view(const ViewOptions& options) {
  if (!is_mesh(options.what.file)) {
    refuse_what_is_no_scene(options.what.file,
                            "a scene (.json), a mesh of tets (.vtu .vtk .msh .node .ele .mesh) or "
                            "the folder of a run");
    refuse_new_scene_flags(options.mesh, "a scene");
    return read_scene_input(options.what);
  }
  if (!options.what.changes.empty()) throw BadInput("--set", "", "a mesh", "a scene");
  NewSceneFlags mesh = options.mesh;
  mesh.request.mesh = options.what.file;
  const NewScene made = new_scene_as_agreed(mesh);
  print_note(fmt::format("{}; {} writes this scene", description_of(made), quoted_command(command_of(made))));
  return load_scene_input(made.first.scene);
}

/// Throws BadInput for a folder that no run has written to. Names a folder of a run in it, if there is one.
void refuse_other_folders(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder / "run.json", ignored)) return;
  fs::path run;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (fs::exists(entry.path() / "run.json", ignored) && (run.empty() || entry.path() < run))
      run = entry.path();
  }
  const std::string example = run.empty() ? "" : fmt::format(", as {}", run.string());
  throw BadInput(folder.string(), "", "a folder without run.json", "the folder of a run" + example);
}

std::unique_ptr<view::Source> open_source(const ViewOptions& options, const InterruptFlag& interrupt) {
  if (fs::is_directory(options.what.file)) {
    if (!options.what.changes.empty()) throw BadInput("--set", "", "the folder of a run", "a scene");
    refuse_new_scene_flags(options.mesh, "the folder of a run");
    refuse_other_folders(options.what.file);
    return as_input([&] { return std::make_unique<view::ReplaySource>(options.what.file, options.threads); });
  }
  SceneInput input = scene_to_view(options);
  relax_model(input.scene, input.model, options.threads, options.json, interrupt);
  return as_input([&] {
    return std::make_unique<view::LiveSource>(input.scene, std::move(input.model), options.threads);
  });
}

/// Throws BadInput, which also names "max".
double parse_speed(const std::string& flag, const std::string& text) {
  try {
    return parse_number(flag, text, scene_format::above(0));
  } catch (const BadInput&) {
    throw BadInput(flag, "", "'" + text + "'", "a number > 0 or 'max'");
  }
}

bool is_loopback(const std::string& host) {
  return host == "::1" || host.starts_with("127.");
}

int serve(ViewOptions options) {
  if (view::page_files().empty()) {
    throw Error("view", "", "a build without the viewer's page",
                "a build with it: install nodejs and npm, then build again");
  }
  options.server.token = token();
  const InterruptFlag interrupt;
  std::unique_ptr<view::Source> source = open_source(options, interrupt);
  view::Server server(options.server, std::move(source), options.player);
  if (!is_loopback(options.server.host)) {
    print_note(
        fmt::format("--host {}: every machine that reaches this one can use the page, if it has the address; "
                    "what is sent is not encrypted",
                    options.server.host));
  }
  const std::string address = server.address();
  if (options.json) {
    print_out(nlohmann::ordered_json{{"address", address}, {"port", server.port()}}.dump() + "\n");
  } else {
    print_out(fmt::format("{}\nCtrl-C ends\n", address));
  }
  if (!options.no_browser) open_browser(address);
  constexpr std::chrono::milliseconds look_up(100);
  while (!interrupt.requested()) server.run_for(look_up);
  return exit_done;
}

void add_flags(CLI::App& app, ViewOptions& options) {
  add_path(app, "SCENE|MESH|DIR", options.what.file,
           "scene file (.json, or '-' for standard input), a mesh of tets, or the folder of a run");
  add_changes(app, options.what.changes);
  add_new_scene_flags(app, options.mesh);
  add_value(app, "--port", "N", "port of the server; default: any free port",
            [&options](const std::string& flag, const std::string& text) {
              options.server.port = static_cast<std::uint16_t>(parse_integer(flag, text, 1, 65535));
            });
  add_value(
      app, "--host", "ADDRESS",
      "address of the server; default 127.0.0.1: this machine only. 0.0.0.0: all machines that can reach it",
      [&options](const std::string& flag, const std::string& text) {
        if (!view::is_address(text)) throw BadInput(flag, "", "'" + text + "'", "an IP address");
        options.server.host = text;
      });
  add_value(
      app, "--name", "HOST", "a further name or address for opening the page (with --host)",
      [&options](const std::string&, const std::string& text) { options.server.names.push_back(text); });
  add_value(app, "--speed", "X|max", "largest ratio of simulated time to wall time; default 1",
            [&options](const std::string& flag, const std::string& text) {
              options.player.speed.reset();
              if (text != "max") options.player.speed = parse_speed(flag, text);
            });
  app.add_flag_callback(
      "--paused", [&options] { options.player.playing = false; }, "start paused");
  app.add_flag("--alone", options.player.alone, "run also while no page is open");
  app.add_flag("--no-browser", options.no_browser, "only print the address");
  add_threads(app, options.threads);
  add_json(app, options.json, "print the address as JSON");
}

}  // namespace

Subcommand add_view(CLI::App& command) {
  CLI::App* app =
      command.add_subcommand("view", "show a scene in the browser, where its bodies can be pulled");
  app->footer(view_examples);
  auto options = std::make_shared<ViewOptions>();
  add_flags(*app, *options);
  return {app, [options] { return serve(*options); }};
}

}  // namespace palpate::app
