#include "mesh_inputs.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <string_view>

#include <palpate/io/mesh_reader.hpp>

#include "exit_codes.hpp"
#include "label_map.hpp"
#include "numbers.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

/// Throws BadInput for a tet mesh, which needs no meshing.
void refuse_tet_mesh(const std::filesystem::path& input) {
  const std::string extension = input.extension().string();
  if (is_surface(input)) return;  // .vtk files may hold either; their reader finds out
  if (std::ranges::count(io::mesh_extensions(), std::string_view(extension)) == 0) return;
  throw BadInput(
      input.string(), "", "a mesh of tets, which needs no meshing",
      "a label map or surfaces; make a scene of it with: palpate new " + path_word(input.string()));
}

void check_conformity(const MeshOptions& options) {
  const Conformity& conformity = options.conformity;
  if (!conformity.wanted) {
    if (conformity.general || !conformity.pairs.empty())
      throw BadInput("--relation", "", "this flag without --conforming", "both flags");
    if (!conformity.focuses.empty())
      throw BadInput("--focus", "", "this flag without --conforming", "both flags");
    return;
  }
  if (!is_label_map(options.inputs.front()))
    throw BadInput("--conforming", "", "surfaces", "a label map: only its labels fill space without gaps");
  const Fineness& fineness = options.fineness;
  if (fineness.tets_each > 0.0 || !fineness.named_tets.empty()) {
    throw BadInput("--tets", "", "a number of tets for single organs, with --conforming",
                   "--tets N for the whole mesh, --size ORGAN=MM for one organ");
  }
  bool open = conformity.general == Relation::open;
  for (const auto& pair : conformity.pairs) open = open || pair.relation == Relation::open;
  if (open != (options.shaping.gap > 0.0)) {
    throw BadInput(open ? "--relation" : "--gap", "",
                   open ? "'open' without --gap" : "this flag with --conforming, but no --relation 'open'",
                   "both flags: --relation A:B=open --gap MM");
  }
}

}  // namespace

void check_mesh_options(const MeshOptions& options) {
  std::size_t maps = 0;
  for (const auto& input : options.inputs) {
    refuse_tet_mesh(input);
    if (is_label_map(input)) {
      ++maps;
    } else if (!is_surface(input)) {
      throw BadInput(
          input.string(), "", "'" + input.extension().string() + "'",
          fmt::format("a label map (.nrrd .nhdr .nii .nii.gz .mha .mhd, a folder) or a surface ({})",
                      surface_extensions));
    }
  }
  if (maps > 0 && options.inputs.size() > 1) {
    throw BadInput("mesh", "", fmt::format("{} inputs", options.inputs.size()), "one label map, or surfaces");
  }
  const Shaping& shaping = options.shaping;
  if (maps > 0 && (shaping.close_holes || shaping.unit_given)) {
    throw BadInput(shaping.close_holes ? "--close-holes" : "--unit", "", "a label map, which is in mm",
                   "surfaces");
  }
  if (maps == 0 && (options.labels || shaping.smoothing_given)) {
    throw BadInput(options.labels ? "--labels" : "--smoothing", "", "surfaces, which have no labels",
                   "a label map");
  }
  const Fineness& fineness = options.fineness;
  if ((fineness.size > 0.0 ? 1 : 0) + (fineness.tets > 0.0 ? 1 : 0) + (fineness.tets_each > 0.0 ? 1 : 0) >
      1) {
    throw BadInput("mesh", "", "more than one of --size, --tets and --tets-each for all organs",
                   "only one of them");
  }
  check_conformity(options);
}

std::string input_name(const MeshOptions& options) {
  std::filesystem::path input = options.inputs.front();
  if (options.inputs.size() > 1) {  // surfaces of one scene: none of them gives it its name
    std::error_code ignored;
    const auto folder =
        std::filesystem::weakly_canonical(options.out.value_or(input.parent_path() / "."), ignored);
    std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
    if (!name.empty()) return name;
  }
  if (!input.has_filename()) input = input.parent_path();  // "folder/"
  for (const char* extension : {".gz", ".nii", ".nrrd", ".seg"}) {
    if (input.extension() == extension) input = input.stem();
  }
  return is_label_map(input) || is_surface(input) ? input.stem().string() : input.filename().string();
}

}  // namespace palpate::app
