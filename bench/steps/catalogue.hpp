#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

/// The scenes of `palpate bench step`: whatever is tuned in the solution of a step is tuned on all of them.
namespace palpate::bench {

/// A scene with its simulation.
struct StepModel {
  Model model{};
  SimulationSettings settings{};
  double meters = 1.0;  ///< of its unit of length
};

/// A scene that can be measured.
struct StepScene {
  std::string name;
  int steps = 0;         ///< of a whole run
  int quick_steps = 0;   ///< of a quick one
  std::size_t tets = 0;  ///< 0: known once it is made
  /// Throws Error if a file is not as it should be.
  std::function<StepModel()> make;
};

/// A scene that cannot be measured, and why.
struct AbsentScene {
  std::string name;
  std::string reason;
};

/// Where scenes are found.
struct StepPlaces {
  std::filesystem::path scenes = "scenes";  ///< stacking.json, eye.json, skull.json and those of CTs
  std::filesystem::path rough;              ///< all *.json there; empty: none
  std::filesystem::path skull;              ///< meshes of the head; empty: none
};

struct StepCatalogue {
  std::vector<StepScene> scenes;
  std::vector<AbsentScene> absent;
};

/// All scenes, in the order that they are measured in. Reads scene files, but no mesh. Throws Error if a
/// scene file is no scene; of the rough ones such a file is absent.
StepCatalogue step_catalogue(const StepPlaces& places);

/// Those of them that need no file: beams, blocks, slabs, piles, unlike neighbours.
std::vector<StepScene> generated_scenes();

}  // namespace palpate::bench
