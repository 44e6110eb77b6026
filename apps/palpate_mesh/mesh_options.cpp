#include "mesh_options.hpp"

#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "exit_codes.hpp"
#include "option_values.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

using scene_format::above;
using scene_format::at_least;

/// Adds a flag that may come several times, each with one value.
template <class Function>
void add_repeated(CLI::App& app, const std::string& flag, const std::string& type, const std::string& help,
                  Function given) {
  const auto all = [flag, given = std::move(given)](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) given(flag, text);
  };
  app.add_option_function<std::vector<std::string>>(flag, all, help)
      ->type_name(type)
      ->allow_extra_args(false);
}

/// "VALUE" for all organs, or "ORGAN=VALUE" for one.
void take_value(const std::string& flag, const std::string& text, double& for_all,
                std::vector<Fineness::Named>& named) {
  const auto equals = text.rfind('=');
  const auto number = [&](const std::string& value) { return parse_number(flag, value, above(0.0)); };
  if (equals == std::string::npos) {
    for_all = number(text);
  } else {
    named.push_back({text.substr(0, equals), number(text.substr(equals + 1))});
  }
}

void add_fineness(CLI::App& app, Fineness& fineness) {
  add_repeated(app, "--tets", "N|ORGAN=N", "tets of all organs together, or of one; default: 10000 together",
               [&](const std::string& flag, const std::string& text) {
                 take_value(flag, text, fineness.tets, fineness.named_tets);
               });
  add_value(app, "--tets-each", "N", "tets of each organ",
            [&](const std::string& flag, const std::string& text) {
              fineness.tets_each = parse_number(flag, text, above(0.0));
            });
  add_repeated(app, "--size", "MM|ORGAN=MM", "size of the triangles in place of a number of tets",
               [&](const std::string& flag, const std::string& text) {
                 take_value(flag, text, fineness.size, fineness.sizes);
               });
  add_value(app, "--cell-share", "X", "size of the tets over that of the triangles; default: 0.9",
            [&](const std::string& flag, const std::string& text) {
              fineness.cell_share = parse_number(flag, text, above(0.0));
            });
  add_value(app, "--max-points", "N", "stop where a mesh has more points; default: 2000000",
            [&](const std::string& flag, const std::string& text) {
              constexpr std::int64_t most = 100'000'000;
              fineness.max_points = static_cast<std::size_t>(parse_integer(flag, text, 1, most));
            });
}

void add_shaping(CLI::App& app, Shaping& shaping) {
  add_value(app, "--smoothing", "S", "blur of label borders, in voxels; 0: none; default: 0.7",
            [&](const std::string& flag, const std::string& text) {
              constexpr scene_format::Limits limits{.low = 0.0, .high = 5.0};
              shaping.smoothing = parse_number(flag, text, limits);
            });
  add_value(app, "--gap", "MM", "distance to leave between organs that touch; default: 0",
            [&](const std::string& flag, const std::string& text) {
              shaping.gap = parse_number(flag, text, at_least(0.0));
            });
}

}  // namespace

void add_mesh_options(CLI::App& app, MeshOptions& options) {
  app.add_option_function<std::vector<std::string>>(
         "INPUT",
         [&options](const std::vector<std::string>& texts) {
           options.inputs.assign(texts.begin(), texts.end());
         },
         "a label map (.nrrd .nhdr .nii .nii.gz .mha .mhd, or a folder with a DICOM series), or closed "
         "surfaces "
         "(.stl .obj .ply .vtp)")
      ->type_name("")
      ->required();
  add_value(app, "--out", "FOLDER",
            "where meshes and scene.json go; default: INPUT-bodies, if that is not there yet",
            [&](const std::string&, const std::string& text) { options.out = text; });
  add_value(app, "--labels", "FILE", "names and colours: a color table of 3D Slicer, or labels of ITK-SNAP",
            [&](const std::string&, const std::string& text) { options.labels = text; });
  const auto keep = [](std::vector<std::string>& list) {
    return [&list](const std::string&, const std::string& text) { list.push_back(text); };
  };
  add_repeated(app, "--only", "ORGAN", "mesh this organ (name or number), and others named so",
               keep(options.only));
  add_repeated(app, "--rigid", "ORGAN", "an organ that does not move or deform in the scene: bone",
               keep(options.rigid));
  add_fineness(app, options.fineness);
  add_shaping(app, options.shaping);
  add_value(app, "--space", "lps|ras",
            "axes of the meshes; default: lps, as DICOM, ITK and files of 3D Slicer",
            [&](const std::string& flag, const std::string& text) {
              constexpr std::array<std::string_view, 2> names{"lps", "ras"};
              options.ras = parse_choice(flag, text, names) == 1;
            });
  add_json(app, options.json, "print the report as JSON");
  app.add_flag("--quiet", options.quiet, "no progress");
}

void check_mesh_options(const MeshOptions& options) {
  std::size_t maps = 0;
  for (const auto& input : options.inputs) {
    if (is_label_map(input)) {
      ++maps;
    } else if (!is_surface(input)) {
      throw BadInput(
          input.string(), "", "'" + input.extension().string() + "'",
          "a label map (.nrrd .nhdr .nii .nii.gz .mha .mhd, a folder) or a surface (.stl .obj .ply .vtp)");
    }
  }
  if (maps > 0 && options.inputs.size() > 1) {
    throw BadInput("mesh", "", fmt::format("{} inputs", options.inputs.size()), "one label map, or surfaces");
  }
  const Fineness& fineness = options.fineness;
  if ((fineness.size > 0.0 ? 1 : 0) + (fineness.tets > 0.0 ? 1 : 0) + (fineness.tets_each > 0.0 ? 1 : 0) >
      1) {
    throw BadInput("mesh", "", "several of --size, --tets, --tets-each for all organs", "one of them");
  }
}

std::string input_name(const MeshOptions& options) {
  std::filesystem::path input = options.inputs.front();
  if (!input.has_filename()) input = input.parent_path();  // "folder/"
  for (const char* extension : {".gz", ".nii", ".nrrd", ".seg"}) {
    if (input.extension() == extension) input = input.stem();
  }
  return is_label_map(input) || is_surface(input) ? input.stem().string() : input.filename().string();
}

}  // namespace palpate::app
