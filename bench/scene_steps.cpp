#include "scene_steps.hpp"

#include <sys/resource.h>
#include <utility>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>

#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "sim/model_check.hpp"

namespace palpate::bench {
namespace {

Model model_of(const Scene& scene) {
  return load_model(scene, [](const std::filesystem::path& path) { return io::read_mesh(path).mesh; });
}

}  // namespace

Simulation simulation_of(const std::filesystem::path& scene_file, const std::optional<Budget>& budget,
                         int threads) {
  Scene scene = read_scene(scene_file);
  Model model = model_of(scene);
  if (scene.relax) relax(model, scene.settings, *scene.relax, threads);
  scene.settings.detection.budget = budget;
  return Simulation(std::move(model), scene.settings, threads);
}

std::vector<std::uint8_t> rigid_bodies_of(const std::filesystem::path& scene) {
  return rigid_bodies(model_of(read_scene(scene)));
}

std::vector<Motion> motions_of(const std::filesystem::path& scene) {
  return model_of(read_scene(scene)).motions;
}

std::int64_t preemptions() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

}  // namespace palpate::bench
