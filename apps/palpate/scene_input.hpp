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

/// What was found while reading a mesh file.
struct MeshRecord {
  std::string file;
  std::string format;
  std::vector<std::pair<std::string, Index>>
      dropped;                                ///< kinds of cells that were left out, with their numbers
  std::vector<io::ConvertedCells> converted;  ///< other cells that were split into tets
  std::vector<Index> reoriented;  ///< tets that had negative volume, 0-based in the file's order of tets
};

/// A mesh file after check_mesh().
struct MeshInput {
  TetMesh mesh;
  MeshRecord record;
};

/// A scene with its bodies.
struct SceneInput {
  Scene scene;  ///< always with a name: that of its file if it has none
  Model model;
  std::vector<std::optional<MeshRecord>> files;  ///< (n_bodies), set for bodies from a mesh file
};

/// The scene that a subcommand works on.
struct SceneChoice {
  std::filesystem::path file;        ///< .json, or "-": standard input
  std::vector<std::string> changes;  ///< changes by --set, each "KEY=VALUE"
};

/// Whether `path` is a scene (.json or "-") and not a mesh, by its extension. Throws BadInput if it is
/// neither.
bool is_scene(const std::filesystem::path& path);
/// Whether the path has the extension of a tet mesh.
bool is_mesh(const std::filesystem::path& path);

/// Throws BadInput, with `expected` in its message, if the file does not exist, or neither has the
/// extension .json nor begins like a scene. Accepts standard input, pipes, and files that other messages
/// refuse: meshes, surfaces, label maps.
void refuse_what_is_no_scene(const std::filesystem::path& path, const std::string& expected);

/// Each throws BadInput: one line that names the file that is wrong.
MeshInput read_mesh_input(const std::filesystem::path& path);
SceneInput read_scene_input(const SceneChoice& choice);
/// Loads the meshes of a scene that was already read.
SceneInput load_scene_input(Scene scene);

/// Makes the simulation of a scene; the model is moved into it. Throws BadInput if a setting is refused.
Simulation make_simulation(const Scene& scene, Model model, int threads);

}  // namespace palpate::app
