#include "steps/catalogue.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>
#include <variant>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>

#include "head_scene.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

double meters(const Units& units) {
  return units.length == "mm" ? 1e-3 : units.length == "cm" ? 1e-2 : 1.0;
}

/// Changes of a scene file, as with --set.
using Changes = std::vector<std::string>;

StepModel load(const fs::path& file, const Changes& changes) {
  const Scene scene = read_scene(file, changes);
  StepModel made{.model = load_model(scene, [](const fs::path& path) { return io::read_mesh(path).mesh; }),
                 .settings = scene.settings,
                 .meters = meters(scene.units)};
  if (scene.relax) relax(made.model, made.settings, *scene.relax, 1);
  return made;
}

/// The first missing mesh file of a scene; empty: none.
fs::path missing_mesh(const Scene& scene) {
  for (const SceneBody& body : scene.bodies) {
    const auto* mesh = std::get_if<MeshFile>(&body.source);
    if (mesh != nullptr && !fs::exists(scene.folder / mesh->path))
      return (scene.folder / mesh->path).lexically_normal();
  }
  return {};
}

/// Adds the scene of a file, with no more steps than it lasts.
void add_file(StepCatalogue& catalogue, const fs::path& file, int steps, int quick_steps,
              const Changes& changes = {}) {
  const std::string name = file.stem().string();
  if (!fs::exists(file)) {
    catalogue.absent.push_back({name, fmt::format("no '{}'", file.string())});
    return;
  }
  const Scene scene = read_scene(file, changes);
  if (const fs::path missing = missing_mesh(scene); !missing.empty()) {
    const char* maker = name.ends_with("-ct") ? "; './dev run' of the scene makes it" : "";
    catalogue.absent.push_back({name, fmt::format("no '{}'{}", missing.string(), maker)});
    return;
  }
  // A duration of 50 steps gives 50 steps, also if the quotient is rounded.
  const double lasts = std::min(scene.duration / scene.settings.time_step + 0.5, 1e6);
  const int most = std::max(1, static_cast<int>(lasts));
  catalogue.scenes.push_back({.name = name,
                              .steps = std::min(steps, most),
                              .quick_steps = std::min(quick_steps, most),
                              .make = [file, changes] { return load(file, changes); }});
}

void add_head(StepCatalogue& catalogue, const fs::path& folder) {
  if (folder.empty()) {
    catalogue.absent.push_back({"head", "its meshes are not at hand (--skull)"});
    return;
  }
  catalogue.scenes.push_back({.name = "head", .steps = 80, .quick_steps = 20, .make = [folder] {
                                HeadScene head = head_scene(folder);
                                return StepModel{.model = std::move(head.model), .settings = head.settings};
                              }});
}

void add_rough(StepCatalogue& catalogue, const fs::path& folder) {
  if (folder.empty()) {
    catalogue.absent.push_back({"rough scenes", "their folder is not named (--rough)"});
    return;
  }
  if (!fs::is_directory(folder))
    throw Error("--rough", "", "no folder '" + folder.string() + "'", "one with scene files");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  constexpr int steps = 250;
  constexpr int quick_steps = 25;
  const Changes changes{"solver.preconditioner=auto"};  // some name one that is gone
  for (const fs::path& file : files) {
    try {
      add_file(catalogue, file, steps, quick_steps, changes);
    } catch (const Error& error) {  // in a folder of the user, files that are no scenes are skipped
      catalogue.absent.push_back({file.stem().string(), error.what()});
    }
  }
}

}  // namespace

StepCatalogue step_catalogue(const StepPlaces& places) {
  StepCatalogue catalogue;
  add_file(catalogue, places.scenes / "stacking.json", 200, 40);
  add_file(catalogue, places.scenes / "eye.json", 120, 40);
  add_file(catalogue, places.scenes / "skull.json", 120, 40);
  add_head(catalogue, places.skull);
  for (const char* name : {"eye-ct.json", "skull-ct.json", "jaw-ct.json"})
    add_file(catalogue, places.scenes / name, 40, 10);
  add_rough(catalogue, places.rough);
  for (StepScene& scene : generated_scenes()) catalogue.scenes.push_back(std::move(scene));
  return catalogue;
}

}  // namespace palpate::bench
