#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "run_loop.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// What pictures of a run need.
struct RunImages {
  std::filesystem::path folder;
  const Scene& scene;
  const Simulation& simulation;  ///< at its end
  std::span<const Vec3> start;   ///< (n_points) positions before the first step
  const RunOutcome& outcome;
  int threads = 0;
};

/// Files of the pictures of a scene: picture.png and the views, in the scene's order.
std::vector<std::filesystem::path> picture_paths(const std::filesystem::path& folder, const Scene& scene);

/// Takes all of them, and says so meanwhile if not quiet. Throws Error where one cannot be taken or written.
void take_pictures(const RunImages& run, bool quiet);

}  // namespace palpate::app
