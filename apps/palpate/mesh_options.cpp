#include "mesh_options.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>

#include "exit_codes.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

using scene_format::above;
using scene_format::at_least;

/// Parses "VALUE" (for all organs) or "ORGAN=VALUE" (for one).
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
  add_repeated(app, "--tets", "N|ORGAN=N",
               "tets of all organs together, or of one; default: 10000 together; with --conforming 55000, or "
               "as many as thin layers need",
               [&](const std::string& flag, const std::string& text) {
                 take_value(flag, text, fineness.tets, fineness.named_tets);
               });
  add_value(app, "--tets-each", "N", "tets of each organ",
            [&](const std::string& flag, const std::string& text) {
              fineness.tets_each = parse_number(flag, text, above(0.0));
            });
  add_repeated(app, "--size", "MM|ORGAN=MM",
               "size of the triangles instead of a number of tets; A:B=MM: where two organs touch",
               [&](const std::string& flag, const std::string& text) {
                 take_value(flag, text, fineness.size, fineness.sizes);
               });
  const auto read_cell_ratio = [&](const std::string& flag, const std::string& text) {
    fineness.cell_ratio = parse_number(flag, text, above(0.0));
  };
  add_value(app, "--cell-ratio", "X", "size of the tets divided by the size of the triangles; default: 0.9",
            read_cell_ratio);
  add_value(app, "--cell-share", "X", "the name of --cell-ratio in 0.2", read_cell_ratio)->group("");
  add_value(app, "--max-points", "N", "stop if a mesh has more points; default: 2000000",
            [&](const std::string& flag, const std::string& text) {
              constexpr std::int64_t most = 100'000'000;
              fineness.max_points = static_cast<std::size_t>(parse_integer(flag, text, 1, most));
            });
}

void add_shaping(CLI::App& app, Shaping& shaping) {
  add_value(app, "--smoothing", "S",
            "blur of label borders, in voxels; 0: none; default: 0.7, or 0.5 with --conforming",
            [&](const std::string& flag, const std::string& text) {
              constexpr scene_format::Limits limits{.low = 0.0, .high = 5.0};
              shaping.smoothing = parse_number(flag, text, limits);
              shaping.smoothing_given = true;
            });
  add_value(app, "--gap", "MM", "distance to leave between organs that touch; default: 0",
            [&](const std::string& flag, const std::string& text) {
              shaping.gap = parse_number(flag, text, at_least(0.0));
            });
  add_value(app, "--close-holes", "MM",
            "close holes of surfaces up to this diameter; default: 5 % of the diagonal",
            [&](const std::string& flag, const std::string& text) {
              shaping.close_holes = parse_number(flag, text, at_least(0.0));
            });
  add_value(app, "--unit", "m|cm|mm|um", "unit of surfaces; the meshes are in mm; default: mm",
            [&](const std::string& flag, const std::string& text) {
              shaping.unit_millimeters = 1e3 * parse_mesh_unit(flag, text).meters;
              shaping.unit_given = true;
            });
}

/// Parses "X,Y,Z,RADIUS=MM".
Conformity::Focus parse_focus(const std::string& flag, const std::string& text) {
  std::array<double, 5> numbers{};
  std::size_t begin = 0;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    const std::size_t end = n < 3 ? text.find(',', begin) : (n == 3 ? text.find('=', begin) : text.size());
    if (end == std::string::npos) throw BadInput(flag, "", "'" + text + "'", "X,Y,Z,RADIUS=MM");
    const std::string number = text.substr(begin, end - begin);
    numbers[n] = parse_number(flag, number, n < 3 ? scene_format::Limits{} : above(0.0));
    begin = end + 1;
  }
  return {{numbers[0], numbers[1], numbers[2]}, numbers[3], numbers[4]};
}

/// Parses "KIND" (for all pairs of organs) or "A:B=KIND" (for one pair).
void take_relation(const std::string& flag, const std::string& text, Conformity& conformity) {
  const auto equals = text.rfind('=');
  const std::string kind = equals == std::string::npos ? text : text.substr(equals + 1);
  const auto relation = static_cast<Relation>(parse_choice(flag, kind, relation_names));
  if (equals == std::string::npos) {
    conformity.general = relation;
  } else {
    conformity.pairs.push_back({text.substr(0, equals), relation});
  }
}

void add_conformity(CLI::App& app, Conformity& conformity) {
  app.add_flag("--conforming", conformity.wanted,
               "one mesh of all labels of a map, without gaps: organs that touch share triangles");
  add_repeated(
      app, "--relation", "KIND|A:B=KIND",
      "relation of organs that touch: grown (one body; the default), slides, or open (--gap apart)",
      [&](const std::string& flag, const std::string& text) { take_relation(flag, text, conformity); });
  add_repeated(app, "--focus", "X,Y,Z,RADIUS=MM", "smaller triangles and tets in a ball, growing around it",
               [&](const std::string& flag, const std::string& text) {
                 conformity.focuses.push_back(parse_focus(flag, text));
               });
}

}  // namespace

constexpr const char* mesh_examples = R"(Examples:
  palpate mesh organs.seg.nrrd                              10000 tets in all; writes organs-bodies/scene.json
  palpate mesh labels.nii.gz --labels names.ctbl --rigid bone --tets 20000 --tets nerve=500 --gap 0.2
  palpate mesh eye.seg.nrrd --conforming --rigid bone --relation bulb:fat=slides
  palpate mesh skull.stl skin.stl --size 4 --out head && palpate run head/scene.json

Meshes are in mm, in LPS (x to the left, y to the back, z to the head); the scene is in mm, g and s.)";

void add_mesh_options(CLI::App& app, MeshOptions& options) {
  app.footer(mesh_examples);
  app.add_option_function<std::vector<std::string>>(
         "INPUT",
         [&options](const std::vector<std::string>& texts) {
           options.inputs.assign(texts.begin(), texts.end());
         },
         "a label map (.nrrd .nhdr .nii .nii.gz .mha .mhd, or a folder with a DICOM series), or closed "
         "surfaces "
         "(.stl .obj .ply .off .vtk .vtp)")
      ->type_name("")
      ->required();
  add_value(app, "--out", "FOLDER",
            "folder for meshes and scene.json; default: INPUT-bodies, if it does not exist yet",
            [&](const std::string&, const std::string& text) { options.out = text; });
  app.add_flag("--replace", options.replace, "write over an existing scene and its meshes");
  add_value(app, "--labels", "FILE", "names and colours: a color table of 3D Slicer, or labels of ITK-SNAP",
            [&](const std::string&, const std::string& text) { options.labels = text; });
  const auto keep = [](std::vector<std::string>& list) {
    return [&list](const std::string&, const std::string& text) { list.push_back(text); };
  };
  add_repeated(app, "--only", "ORGAN", "mesh only this organ (name or number); may be repeated",
               keep(options.only));
  add_repeated(app, "--rigid", "ORGAN", "an organ that does not move or deform in the scene: bone",
               keep(options.rigid));
  add_fineness(app, options.fineness);
  add_shaping(app, options.shaping);
  add_conformity(app, options.conformity);
  add_value(app, "--space", "lps|ras",
            "axes of the meshes; default: lps, as DICOM, ITK and files of 3D Slicer",
            [&](const std::string& flag, const std::string& text) {
              constexpr std::array<std::string_view, 2> names{"lps", "ras"};
              options.ras = parse_choice(flag, text, names) == 1;
            });
  add_json(app, options.json, "print the report as JSON");
  app.add_flag("--quiet", options.quiet, "no progress");
}

}  // namespace palpate::app
