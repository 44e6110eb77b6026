#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/simulation.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// What reading a mesh file met.
struct MeshRecord {
  std::string file;
  std::string format;
  std::vector<std::pair<std::string, Index>> dropped;  ///< kinds of cells that are no tets, and how many
  std::vector<io::ConvertedCells> converted;           ///< other cells that tets were made of
  std::vector<Index> reoriented;  ///< tets that had negative volume, 0-based in the file's order of tets
};

/// A mesh file after check_mesh().
struct MeshInput {
  TetMesh mesh;
  MeshRecord record;
};

/// A scene with its bodies.
struct SceneInput {
  Scene scene;  ///< named: after its file where it has no name
  Model model;
  std::vector<std::optional<MeshRecord>> files;  ///< (n_bodies), of those from a mesh file
};

/// Which scene a subcommand is about.
struct SceneChoice {
  std::filesystem::path file;        ///< .json, or "-": standard input
  std::vector<std::string> changes;  ///< "KEY=VALUE" each, of --set
};

/// Whether `path` means a scene (.json or "-"), not a mesh. Throws BadInput where it is neither by its
/// extension.
bool is_scene(const std::filesystem::path& path);
/// Whether its extension is that of a mesh of tets.
bool is_mesh(const std::filesystem::path& path);

/// Throws BadInput with what is `expected` where there is no such file, or its name does not end in .json and
/// it does not begin as a scene does. Says nothing of standard input, pipes and files that other messages are
/// for: meshes, surfaces, label maps.
void refuse_what_is_no_scene(const std::filesystem::path& path, const std::string& expected);

/// Each throws BadInput: one line that names the file that is wrong.
MeshInput read_mesh_input(const std::filesystem::path& path);
SceneInput read_scene_input(const SceneChoice& choice);
/// The meshes of a scene that is there already.
SceneInput load_scene_input(Scene scene);

/// The simulation of a scene; takes the model. Throws BadInput where a setting is refused.
Simulation make_simulation(const Scene& scene, Model model, int threads);

}  // namespace palpate::app
