#include "generate_anatomy.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "anatomy/organs.hpp"
#include "exit_codes.hpp"
#include "io/vtu_writer.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate generate eye --out scenes/meshes/eye             the meshes of scenes/eye.json
  palpate generate skull --out scenes/meshes/skull         the meshes of scenes/skull.json)";

/// The folder to write to: one that was named may be there already, the default may not.
fs::path folder_for(const std::string& name, const std::optional<fs::path>& named) {
  std::error_code ignored;
  fs::path folder = named.value_or(name);
  if (!named && fs::exists(folder, ignored)) {
    throw BadInput(folder.string(), "", "something of that name already",
                   "--out DIR, whose files may be replaced");
  }
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw BadInput(folder.string(), "", "'" + failed.message() + "'", "a folder to write to");
  return folder;
}

void write_organs(const fs::path& folder, const std::vector<anatomy::Organ>& organs) {
  for (const anatomy::Organ& organ : organs) {
    const fs::path path = folder / (organ.name + ".vtu");
    io::write_vtu(path, {.points = organ.mesh.points,
                         .tets = organ.mesh.tets,
                         .point_arrays = {},
                         .tet_arrays = {},
                         .time = {}});
    print_out(fmt::format("{}: {}, {}\n", path.string(), counted(organ.mesh.points.size(), "point"),
                          counted(organ.mesh.tets.size(), "tet")));
  }
}

Subcommand add_organs(CLI::App& generate, const std::string& name, const std::string& help,
                      std::function<std::vector<anatomy::Organ>()> make) {
  CLI::App* app = generate.add_subcommand(name, help);
  app->footer(examples);
  auto named = std::make_shared<std::optional<fs::path>>();
  add_value(*app, "--out", "DIR", "folder of the meshes, NAME.vtu each, in mm; default: " + name,
            [named](const std::string&, const std::string& text) { *named = text; });
  return {app, [name, named, make = std::move(make)] {
            fs::path folder = folder_for(name, *named);
            write_organs(folder, make());
            return exit_done;
          }};
}

}  // namespace

std::vector<Subcommand> add_generate_anatomy(CLI::App& generate) {
  return {add_organs(generate, "eye", "meshes: an orbit with bulb, recti, nerve, fat, skin, bone and plate",
                     anatomy::make_eye),
          add_organs(generate, "skull", "meshes: a face with skull, upper jaw, lower jaw and soft tissue",
                     anatomy::make_skull)};
}

}  // namespace palpate::app
