#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "run_loop.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// The input of the pictures of a run.
struct RunImages {
  std::filesystem::path folder;
  const Scene& scene;
  const Simulation& simulation;            ///< at its end
  std::span<const Vec3> start;             ///< (n_points) positions before the first step
  std::span<const Index> material_of_tet;  ///< Model::material_of_tet
  const RunOutcome& outcome;
  int threads = 0;
};

/// Files of the pictures of a scene: picture.png and the views, in the scene's order.
std::vector<std::filesystem::path> picture_paths(const std::filesystem::path& folder, const Scene& scene);

/// Draws all pictures, with a message meanwhile unless `quiet`. Throws Error if one cannot be drawn or
/// written.
void render_pictures(const RunImages& run, bool quiet);

/// Pictures of the ends of stages: RESULTS/stages/NAME.png and NAME.VIEW.png for each view of an end.
class StagePictures {
 public:
  /// Borrows all but the folder, as RunImages.
  StagePictures(std::filesystem::path folder, const Scene& scene, const Simulation& simulation,
                std::span<const Vec3> start, std::span<const Index> material_of_tet, int threads)
      : folder_(std::move(folder)),
        scene_(scene),
        simulation_(simulation),
        start_(start),
        material_of_tet_(material_of_tet),
        threads_(threads) {}
  /// Draws the pictures of a stage. Throws Error if one cannot be drawn or written.
  void take(const std::string& stage, const RunOutcome& outcome) const;

 private:
  std::filesystem::path folder_;
  const Scene& scene_;
  const Simulation& simulation_;
  std::span<const Vec3> start_;
  std::span<const Index> material_of_tet_;
  int threads_;
};

/// The files of a stage's pictures, in the scene's order.
std::vector<std::filesystem::path> stage_picture_paths(const std::filesystem::path& folder,
                                                       const Scene& scene, const std::string& stage);

}  // namespace palpate::app
