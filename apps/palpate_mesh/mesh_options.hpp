#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mesh_plan.hpp"
#include "organ.hpp"

namespace palpate::app {

/// What `palpate mesh` was asked for.
struct MeshOptions {
  std::vector<std::filesystem::path> inputs;  ///< one label map, or surfaces
  std::optional<std::filesystem::path>
      out;  ///< folder; none: named after the input, and must not be there yet
  std::optional<std::filesystem::path> labels;  ///< table of names
  std::vector<std::string> only;                ///< organs to mesh, by name or number; empty: all
  std::vector<std::string> rigid;               ///< organs that become obstacles
  Fineness fineness;
  Shaping shaping;
  bool ras = false;  ///< meshes in RAS in place of LPS
  bool json = false;
  bool quiet = false;
};

/// Adds the flags of `palpate mesh`; they change `options` when the command is parsed.
void add_mesh_options(CLI::App& app, MeshOptions& options);

/// Throws BadInput where the flags do not fit each other.
void check_mesh_options(const MeshOptions& options);

/// What the input is called: the file name of the first without folder and extensions (".seg.nrrd",
/// ".nii.gz").
std::string input_name(const MeshOptions& options);

}  // namespace palpate::app
