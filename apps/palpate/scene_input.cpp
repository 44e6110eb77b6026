#include "scene_input.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <variant>

#include "exit_codes.hpp"
#include "io/mesh_reader.hpp"
#include "scene/suggest.hpp"

namespace palpate::app {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_mesh_extension(const std::string& extension) {
  return std::ranges::count(io::mesh_extensions(), std::string_view(extension)) > 0;
}

/// Tets whose corners are in another order than before.
std::vector<Index> changed_tets(const std::vector<Tet>& before, const std::vector<Tet>& after) {
  std::vector<Index> changed;
  for (std::size_t t = 0; t < after.size(); ++t) {
    if (before[t] != after[t]) changed.push_back(static_cast<Index>(t));
  }
  return changed;
}

MeshInput read_checked(const std::filesystem::path& path) {
  io::MeshFile file = io::read_mesh(path);
  MeshInput input{std::move(file.mesh), {path.string(), std::move(file.format), std::move(file.dropped), {}}};
  const std::vector<Tet> tets = input.mesh.tets;
  check_mesh(input.mesh, path.string());  // here and not only in Bodies::add(), so that errors name the file
  input.record.reoriented = changed_tets(tets, input.mesh.tets);
  return input;
}

}  // namespace

bool is_scene(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".json") return true;
  if (is_mesh_extension(extension)) return false;
  std::vector<std::string_view> known{".json"};
  known.insert(known.end(), io::mesh_extensions().begin(), io::mesh_extensions().end());
  throw BadInput(path.string(), "", extension.empty() ? "no extension" : "the extension " + extension,
                 expected_name("", known) + " (.json is a scene, the others are meshes)");
}

MeshInput read_mesh_input(const std::filesystem::path& path) {
  return as_input([&] { return read_checked(path); });
}

SceneInput read_scene_input(const std::filesystem::path& path) {
  if (is_mesh_extension(lower_extension(path))) {
    throw BadInput(path.string(), "", "a mesh file", "a scene file (.json) that names the mesh");
  }
  Scene scene = as_input([&] { return read_scene(path); });
  if (scene.name.empty()) scene.name = path.stem().string();
  return load_scene_input(std::move(scene));
}

SceneInput load_scene_input(Scene scene) {
  return as_input([&] {
    SceneInput input;
    input.scene = std::move(scene);
    std::vector<MeshRecord> records;
    input.model = load_model(input.scene, [&](const std::filesystem::path& file) {
      MeshInput mesh = read_checked(file);
      records.push_back(std::move(mesh.record));
      return std::move(mesh.mesh);
    });
    auto next = records.begin();
    for (const SceneBody& body : input.scene.bodies) {
      const bool from_file = std::holds_alternative<MeshFile>(body.source);
      input.files.push_back(from_file ? std::optional(std::move(*next++)) : std::nullopt);
    }
    return input;
  });
}

Simulation make_simulation(const Scene& scene, Model model, int threads) {
  return as_input([&] { return Simulation(std::move(model), scene.settings, threads); });
}

}  // namespace palpate::app
