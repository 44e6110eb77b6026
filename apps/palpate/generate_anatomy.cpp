#include "generate_anatomy.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "anatomy/eye_labels.hpp"
#include "anatomy/organs.hpp"
#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "io/vtu_writer.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* examples = R"(Examples:
  palpate generate eye --out scenes/meshes/eye             the meshes of scenes/eye.json
  palpate generate skull --out scenes/meshes/skull         the meshes of scenes/skull.json
  palpate generate eye-labels --out eye.seg.nrrd && palpate mesh eye.seg.nrrd --conforming --rigid bone)";

/// The folder to write to. A folder that the user names may exist, the default folder may not.
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

/// An NRRD file with the names of segments as 3D Slicer writes them; LPS.
std::string nrrd_of(const anatomy::OrganLabels& map) {
  std::string text = fmt::format(
      "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: {0} {1} {2}\n"
      "space directions: ({3},0,0) (0,{3},0) (0,0,{3})\nkinds: domain domain domain\nencoding: raw\n"
      "space origin: ({4},{5},{6})\n",
      map.size[0], map.size[1], map.size[2], map.edge, map.origin.x, map.origin.y, map.origin.z);
  for (std::size_t l = 0; l < map.names.size(); ++l)
    text += fmt::format("Segment{0}_LabelValue:={1}\nSegment{0}_Name:={2}\n", l, l + 1, map.names[l]);
  text += "\n";
  text.append(map.labels.begin(), map.labels.end());
  return text;
}

Subcommand add_eye_labels(CLI::App& generate) {
  struct Options {
    fs::path out{"eye.seg.nrrd"};
    double voxel = 1.0;
  };
  CLI::App* app = generate.add_subcommand(
      "eye-labels", "a label map: the orbit of 'eye' as a segmentation, organs without gaps, no plate");
  app->footer(examples);
  auto options = std::make_shared<Options>();
  add_value(*app, "--out", "FILE", "where to write it (.nrrd), in mm; default: eye.seg.nrrd",
            [options](const std::string&, const std::string& text) { options->out = text; });
  add_value(*app, "--voxel", "MM", "edge of a voxel, 0.25 to 4; default: 1",
            [options](const std::string& flag, const std::string& text) {
              constexpr scene_format::Limits limits{.low = 0.25, .high = 4.0};
              options->voxel = parse_number(flag, text, limits);
            });
  return {app, [options] {
            const anatomy::OrganLabels map = anatomy::eye_labels(options->voxel);
            io::write_atomically(options->out, nrrd_of(map));
            print_out(fmt::format("{}: {} x {} x {} voxels, {} labels\n", options->out.string(), map.size[0],
                                  map.size[1], map.size[2], map.names.size()));
            return exit_done;
          }};
}

}  // namespace

std::vector<Subcommand> add_generate_anatomy(CLI::App& generate) {
  return {add_organs(generate, "eye", "meshes: an orbit with bulb, recti, nerve, fat, skin, bone and plate",
                     anatomy::make_eye),
          add_eye_labels(generate),
          add_organs(generate, "skull", "meshes: a face with skull, upper jaw, lower jaw and soft tissue",
                     anatomy::make_skull)};
}

}  // namespace palpate::app
