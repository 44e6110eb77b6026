#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "scene/scene.hpp"

namespace palpate::view {

/// The stages of a stored run: which bodies are absent or rigid in its frames.
class StoredStages {
 public:
  StoredStages() = default;
  /// \param ends  times at which stages ended, in order; a run that was interrupted has fewer than the scene
  ///
  /// Throws Error if there are more ends than stages.
  StoredStages(const Scene& scene, std::vector<double> ends);

  [[nodiscard]] bool any() const { return bodies_.size() > 1; }
  /// The number of the stage in which a frame was written, from 1; 0: the run has none. The frame at the end
  /// of a stage belongs to that stage.
  [[nodiscard]] std::size_t stage_of(double time) const;
  /// (n_bodies) 1: absent in this stage.
  [[nodiscard]] const std::vector<std::uint8_t>& absent(std::size_t stage) const {
    return bodies_[stage].absent;
  }
  /// (n_bodies) 1: rigid in this stage.
  [[nodiscard]] const std::vector<std::uint8_t>& rigid(std::size_t stage) const {
    return bodies_[stage].rigid;
  }
  /// For the page, as LiveSource tells it.
  [[nodiscard]] nlohmann::ordered_json json(double time) const;

 private:
  struct BodiesOfStage {
    std::vector<std::uint8_t> absent;
    std::vector<std::uint8_t> rigid;
  };
  std::vector<BodiesOfStage> bodies_;  ///< at the start, then in each stage
  std::vector<std::string> names_;
  std::vector<double> ends_;
  double slack_ = 0.0;  ///< half a time step: files round times
};

/// The names of the stages of a scene, for Stage::about.
nlohmann::ordered_json stage_names_json(const Scene& scene);

}  // namespace palpate::view
