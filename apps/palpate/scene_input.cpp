#include "scene_input.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <variant>

#include <palpate/io/cell_vectors.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "exit_codes.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "scene/suggest.hpp"
#include "size_warnings.hpp"
#include "tissue_presets.hpp"

namespace palpate::app {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool has_extension(const std::filesystem::path& path, std::initializer_list<std::string_view> list) {
  return std::ranges::count(list, std::string_view(lower_extension(path))) > 0;
}
bool is_surface(const std::filesystem::path& path) {
  return has_extension(path, {".stl", ".obj", ".ply", ".off", ".vtp"});
}
bool is_label_map(const std::filesystem::path& path) {
  return has_extension(path, {".nrrd", ".nhdr", ".nii", ".mha", ".mhd"}) ||
         (has_extension(path, {".gz"}) && has_extension(path.stem(), {".nii"}));
}

/// Whether the text begins with an object or a comment, like a scene.
bool begins_as_a_scene(const std::filesystem::path& path) {
  std::ifstream file(path);
  char first = 0;
  return (file >> first) && (first == '{' || first == '/');
}

/// Throws BadInput for surfaces and label maps, with the command that makes meshes of them.
/// \param expected  what is wanted instead of the file
void refuse_what_is_to_be_meshed(const std::filesystem::path& path, const std::string& expected) {
  const bool surface = is_surface(path);
  if (!surface && !is_label_map(path)) return;
  throw BadInput(path.string(), "", surface ? "a surface" : "a label map",
                 expected + "; make one, with its meshes, with: palpate mesh " + path_word(path.string()));
}

/// Throws BadInput for files of other kinds (meshes, surfaces, label maps), with the command that converts
/// them.
void refuse_other_kinds(const std::filesystem::path& path) {
  if (is_mesh(path)) {
    throw BadInput(path.string(), "", "a mesh file",
                   "a scene file (.json); make one with: palpate new " + path_word(path.string()));
  }
  refuse_what_is_to_be_meshed(path, "a scene file (.json)");
}

/// All of standard input. Relative paths in it are relative to the current folder.
std::string standard_input() {
  if (::isatty(STDIN_FILENO) == 1) print_note("reading the scene from the terminal; Ctrl-D ends it");
  std::string text;
  std::array<char, 65536> bytes{};
  constexpr std::size_t most = std::size_t{1} << 30;
  while (const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), stdin)) {
    text.append(bytes.data(), count);
    if (text.size() > most) throw BadInput("stdin", "", "more than 1 GB", "a scene file");
  }
  if (text.empty()) throw BadInput("stdin", "", "nothing", "a scene file");
  return text;
}

Scene read_chosen(const SceneChoice& choice) {
  if (choice.file == "-") return read_scene_text(standard_input(), "stdin", {}, choice.changes);
  return read_scene(choice.file, choice.changes);
}

/// Indices of tets whose corners are in another order than before.
std::vector<Index> changed_tets(const std::vector<Tet>& before, const std::vector<Tet>& after) {
  std::vector<Index> changed;
  for (std::size_t t = 0; t < after.size(); ++t) {
    if (before[t] != after[t]) changed.push_back(static_cast<Index>(t));
  }
  return changed;
}

MeshInput read_checked(const std::filesystem::path& path) {
  io::MeshFile file = io::read_mesh(path);
  MeshInput input{
      std::move(file.mesh),
      {path.string(), std::move(file.format), std::move(file.dropped), std::move(file.converted), {}}};
  const std::vector<Tet> tets = input.mesh.tets;
  check_mesh(input.mesh, path.string());  // checked here, before Bodies::add(), so that errors name the file
  input.record.reoriented = changed_tets(tets, input.mesh.tets);
  return input;
}

}  // namespace

bool is_mesh(const std::filesystem::path& path) {
  return std::ranges::count(io::mesh_extensions(), std::string_view(lower_extension(path))) > 0;
}

bool is_scene(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".json" || path == "-") return true;
  if (is_mesh(path)) return false;
  refuse_what_is_to_be_meshed(path, "a scene or a tet mesh");
  std::vector<std::string_view> known{".json"};
  known.insert(known.end(), io::mesh_extensions().begin(), io::mesh_extensions().end());
  throw BadInput(path.string(), "", extension.empty() ? "no extension" : "the extension " + extension,
                 expected_name("", known) + " (.json is a scene, the others are meshes)");
}

void refuse_what_is_no_scene(const std::filesystem::path& path, const std::string& expected) {
  if (path == "-" || is_mesh(path) || is_surface(path) || is_label_map(path)) return;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw BadInput(path.string(), "", "no such file or folder", expected);
  const bool file = std::filesystem::is_regular_file(path, ignored);
  if (lower_extension(path) != ".json" && file && !begins_as_a_scene(path))
    throw BadInput(path.string(), "", "a file that is neither a mesh nor a scene", expected);
}

MeshInput read_mesh_input(const std::filesystem::path& path) {
  return as_input([&] { return read_checked(path); });
}

SceneInput read_scene_input(const SceneChoice& choice) {
  refuse_other_kinds(choice.file);
  Scene scene = as_input([&] { return read_chosen(choice); });
  if (scene.name.empty()) scene.name = choice.file == "-" ? "stdin" : choice.file.stem().string();
  return load_scene_input(std::move(scene));
}

SceneInput load_scene_input(Scene scene) {
  return as_input([&] {
    SceneInput input;
    input.scene = std::move(scene);
    std::vector<MeshRecord> records;
    input.model = load_model(
        input.scene,
        [&](const std::filesystem::path& file) {
          MeshInput mesh = read_checked(file);
          records.push_back(std::move(mesh.record));
          return std::move(mesh.mesh);
        },
        io::read_cell_data);
    auto next = records.begin();
    for (const SceneBody& body : input.scene.bodies) {
      const bool from_file = std::holds_alternative<MeshFile>(body.source);
      input.files.push_back(from_file ? std::optional(std::move(*next++)) : std::nullopt);
    }
    warn_of_sizes(input.scene, input.model);
    warn_of_presets(input.scene);
    return input;
  });
}

Simulation make_simulation(const Scene& scene, Model model, int threads) {
  return as_input([&] { return Simulation(std::move(model), scene.settings, threads); });
}

}  // namespace palpate::app
