// A scene file. write_scene() must reproduce an accepted scene, and small scenes are simulated for a step.
#include <algorithm>
#include <variant>

#include <palpate/simulation.hpp>

#include "fuzz/fuzzing.hpp"
#include "scene/generators.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace {

using namespace palpate;

/// Scenes of any size are allowed; those that take long are left out.
bool is_small(const Scene& scene) {
  if (scene.bodies.size() > 4) return false;
  return std::ranges::all_of(scene.bodies, [](const SceneBody& body) {
    if (const auto* box = std::get_if<BoxGenerator>(&body.source))
      return std::ranges::all_of(box->cells, [](int cells) { return cells <= 3; });
    if (const auto* ball = std::get_if<BallGenerator>(&body.source)) return ball->resolution <= 3;
    return true;
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::refusing([&] {
    Scene scene = read_scene_text(fuzz::text(data, size), "fuzz");
    const std::string written = write_scene(scene);
    fuzz::require(write_scene(read_scene_text(written, "fuzz")) == written);
    if (!is_small(scene)) return;
    scene.settings.solver.max_solves = std::min(scene.settings.solver.max_solves, 3);
    scene.settings.solver.max_substeps = std::min(scene.settings.solver.max_substeps, 2);
    scene.settings.solver.max_iterations = std::min(scene.settings.solver.max_iterations, 50);
    if (scene.settings.solver.fixed_iterations) scene.settings.solver.fixed_iterations = 3;
    Model model = load_model(scene, [](const std::filesystem::path&) {
      return make_box({1, 1, 1}, {1.0, 1.0, 1.0});
    });
    Simulation simulation(std::move(model), scene.settings, 1);
    simulation.step();
  });
  return 0;
}
