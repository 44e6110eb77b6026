#include "scene_steps.hpp"

#include <sys/resource.h>
#include <utility>

#include <palpate/relax.hpp>

#include "apps/palpate/scene_input.hpp"
#include "sim/model_check.hpp"

namespace palpate::bench {

Simulation simulation_of(const std::filesystem::path& scene, const std::optional<Budget>& budget,
                         int threads) {
  app::SceneInput input = app::read_scene_input(scene);
  if (input.scene.relax) relax(input.model, input.scene.settings, *input.scene.relax, threads);
  input.scene.settings.detection.budget = budget;
  return app::make_simulation(input.scene, std::move(input.model), threads);
}

std::vector<std::uint8_t> rigid_bodies_of(const std::filesystem::path& scene) {
  return rigid_bodies(app::read_scene_input(scene).model);
}

std::int64_t preemptions() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

}  // namespace palpate::bench
