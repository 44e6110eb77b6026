#pragma once

#include <nlohmann/json.hpp>

#include "steps/catalogue.hpp"

namespace palpate::bench {

using Json = nlohmann::ordered_json;

/// How scenes are measured.
struct StepEffort {
  int threads = 1;
  std::optional<int> steps{};  ///< of each scene; none: those of the catalogue
  bool quick = false;
  std::size_t most_tets = static_cast<std::size_t>(-1);
  std::optional<Preconditioner> preconditioner{};  ///< none: that of the scene
  std::optional<double> tolerance{};
  /// Tolerance of a second run of each scene, with whose last positions those of the first are compared.
  std::optional<double> reference{};
};

/// Largest size of the scenes of a quick run.
inline constexpr std::size_t quick_tets = 30000;

/// A row of the table: what the steps of a scene took and how they ended. A scene that cannot continue has
/// why in "error", and figures of the steps before; null where a scene has more tets than are wanted. Work is
/// in products with the matrix of the scene (ProductClock): all time of the solver over that of one product.
/// With a reference "position_error" has how far points are from it in the end, as fractions of the mean edge
/// length of their body: {"largest", "rms"}.
Json scene_row(const StepScene& scene, const StepEffort& effort);

}  // namespace palpate::bench
