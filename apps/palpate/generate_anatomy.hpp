#pragma once

#include <filesystem>
#include <vector>

#include <palpate/mesh.hpp>

#include "subcommands.hpp"

namespace palpate::app {

/// Writes a mesh to a file (.vtu), and prints its name and counts.
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh);

/// Adds `eye`, `skull` and others to `generate`: meshes and label maps of the medical scenes.
std::vector<Subcommand> add_generate_anatomy(CLI::App& generate);

}  // namespace palpate::app
