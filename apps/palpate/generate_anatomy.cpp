#include "generate_anatomy.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "anatomy/organ_labels.hpp"
#include "anatomy/organs.hpp"
#include "exit_codes.hpp"
#include "generated_file.hpp"
#include "messages.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* anatomy_examples = R"(Examples:
  palpate generate eye --out scenes/meshes/eye             the meshes of scenes/eye.json
  palpate generate skull --out scenes/meshes/skull         the meshes of scenes/skull.json
  palpate generate eye-labels --out eye.seg.nrrd && palpate mesh eye.seg.nrrd --conforming --rigid bone
  palpate generate orbit-labels --defect 13,16 --out orbit.seg.nrrd      an orbit with a broken floor (docs/orbit.md))";

/// The folder to write to. A folder that the user names may exist, the default folder may not.
fs::path folder_for(const std::string& name, const std::optional<fs::path>& named) {
  std::error_code ignored;
  fs::path folder = named.value_or(name);
  if (!named && fs::exists(folder, ignored)) {
    throw BadInput(folder.string(), "", "an existing file or folder",
                   "a name that does not exist yet; --out FOLDER replaces files in an existing folder");
  }
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored))
    throw BadInput(folder.string(), "", "a file", "a folder to write to");
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(folder.string(), "", "'" + failed.message() + "'", "a folder to write to");
  return folder;
}

void write_organs(const fs::path& folder, const std::function<std::vector<anatomy::Organ>()>& make) {
  const std::vector<anatomy::Organ> organs = made(make);
  const InterruptFlag interrupt;
  std::size_t written = 0;
  const auto check = [&] {
    stop_if_interrupted(interrupt,
                        fmt::format("{} has {} of {} meshes", folder.string(), written, organs.size()));
  };
  check();
  for (const anatomy::Organ& organ : organs) {
    write_mesh(folder / (organ.name + ".vtu"), organ.mesh);
    ++written;
    check();
  }
}

Subcommand add_organs(CLI::App& generate, const std::string& name, const std::string& help,
                      std::function<std::vector<anatomy::Organ>()> make) {
  CLI::App* app = generate.add_subcommand(name, help);
  app->footer(anatomy_examples);
  auto named = std::make_shared<std::optional<fs::path>>();
  add_value(*app, "--out", "DIR", "folder of the meshes, NAME.vtu each, in mm; default: " + name,
            [named](const std::string&, const std::string& text) { *named = text; });
  return {app, [name, named, make = std::move(make)] {
            write_organs(folder_for(name, *named), make);
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

struct LabelOptions {
  GeneratedFile out;
  double voxel = 1.0;
  anatomy::FloorDefect defect;
};

/// Adds a generator of a label map. `make` is called with the options that the user gave.
Subcommand add_labels(CLI::App& generate, const std::string& name, const std::string& help,
                      const std::shared_ptr<LabelOptions>& options,
                      std::function<anatomy::OrganLabels(const LabelOptions&)> make) {
  CLI::App* app = generate.add_subcommand(name, help);
  app->footer(anatomy_examples);
  add_out(*app, "where to write it (.nrrd), in mm", options->out);
  add_value(*app, "--voxel", "MM", "edge of a voxel, 0.25 to 4; default: 1",
            [options](const std::string& flag, const std::string& text) {
              constexpr scene_format::Limits limits{.low = 0.25, .high = 4.0};
              options->voxel = parse_number(flag, text, limits);
            });
  return {app, [options, make = std::move(make)] {
            anatomy::OrganLabels map;
            const fs::path path = write_generated(options->out, [&] {
              map = make(*options);
              return nrrd_of(map);
            });
            print_out(fmt::format("{}: {} x {} x {} voxels, {} labels\n", path.string(), map.size[0],
                                  map.size[1], map.size[2], map.names.size()));
            return exit_done;
          }};
}

Subcommand add_eye_labels(CLI::App& generate) {
  return add_labels(generate, "eye-labels",
                    "a label map: the orbit of 'eye' as a segmentation, organs without gaps, no plate",
                    std::make_shared<LabelOptions>(LabelOptions{.out = {"eye.seg.nrrd", {}}, .defect = {}}),
                    [](const LabelOptions& options) { return anatomy::eye_labels(options.voxel); });
}

/// Parses two numbers "A,B".
std::pair<double, double> parse_pair(const std::string& flag, const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) throw BadInput(flag, "", "'" + text + "'", "two numbers: A,B");
  return {parse_number(flag, text.substr(0, comma), scene_format::Limits{}),
          parse_number(flag, text.substr(comma + 1), scene_format::Limits{})};
}

/// Calls make(). If it refuses a value, the message names the flag that gave it: `size` gives a width and a
/// length, `place` an x and a y.
template <class Make>
auto with_flags(const std::string& size, const std::string& place, Make&& make) {
  try {
    return make();
  } catch (const Error& error) {
    const std::string& what = error.where();
    if (what == "width" || what == "length") throw BadInput(size, what, error.found(), error.expected());
    if (what == "x" || what == "y") throw BadInput(place, what, error.found(), error.expected());
    throw BadInput("--" + what, "", error.found(), error.expected());
  }
}

Subcommand add_orbit_labels(CLI::App& generate) {
  auto options = std::make_shared<LabelOptions>(LabelOptions{.out = {"orbit.seg.nrrd", {}}, .defect = {}});
  Subcommand command =
      add_labels(generate, "orbit-labels",
                 "a label map: an orbit over a sinus, with a piece of its floor that breaks out", options,
                 [](const LabelOptions& wanted) {
                   return with_flags("--defect", "--defect-at",
                                     [&] { return anatomy::orbit_labels(wanted.voxel, wanted.defect); });
                 });
  add_value(*command.app, "--defect", "WIDTH,LENGTH",
            "size of the piece along x and y, mm, up to 22,24; default: 13,16",
            [options](const std::string& flag, const std::string& text) {
              std::tie(options->defect.width, options->defect.length) = parse_pair(flag, text);
            });
  add_value(*command.app, "--defect-at", "X,Y", "its centre, mm from the centre of the bulb; default: -2,7",
            [options](const std::string& flag, const std::string& text) {
              std::tie(options->defect.x, options->defect.y) = parse_pair(flag, text);
            });
  return command;
}

Subcommand add_orbit_plate(CLI::App& generate) {
  struct Options {
    GeneratedFile out{"plate.vtu", {}};
    anatomy::OrbitPlate plate;
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = generate.add_subcommand(
      "orbit-plate", "a mesh: a plate for the floor of 'orbit-labels', bent as it is or flat");
  app->footer(anatomy_examples);
  add_out(*app, "where to write it (.vtu), in mm", options->out);
  add_value(*app, "--size", "WIDTH,LENGTH", "along x and y, mm; default: 17,20",
            [options](const std::string& flag, const std::string& text) {
              std::tie(options->plate.width, options->plate.length) = parse_pair(flag, text);
            });
  add_value(*app, "--at", "X,Y", "its middle, mm from the centre of the bulb; default: -2,7",
            [options](const std::string& flag, const std::string& text) {
              std::tie(options->plate.x, options->plate.y) = parse_pair(flag, text);
            });
  const auto add_length = [&](const char* flag, const char* help, double& value) {
    add_value(*app, flag, "MM", help, [options, &value](const std::string& given, const std::string& text) {
      value = parse_number(given, text, scene_format::Limits{});
    });
  };
  app->add_flag("--flat", options->plate.flat, "flat, and lies on the floor");
  add_length("--thickness", "default: 0.8", options->plate.thickness);
  add_length("--above", "of its lower side over the floor; default: 0.6", options->plate.above);
  return {app, [options] {
            write_generated_mesh(options->out, [&] {
              return with_flags("--size", "--at", [&] { return anatomy::make_orbit_plate(options->plate); });
            });
            return exit_done;
          }};
}

}  // namespace

std::vector<Subcommand> add_generate_anatomy(CLI::App& generate) {
  return {add_organs(generate, "eye", "meshes: an orbit with bulb, recti, nerve, fat, skin, bone and plate",
                     anatomy::make_eye),
          add_eye_labels(generate), add_orbit_labels(generate), add_orbit_plate(generate),
          add_organs(generate, "skull", "meshes: a face with skull, upper jaw, lower jaw and soft tissue",
                     anatomy::make_skull)};
}

}  // namespace palpate::app
