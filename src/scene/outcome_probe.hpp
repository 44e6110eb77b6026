#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <palpate/outcomes.hpp>
#include <palpate/simulation.hpp>

#include "scene/scene.hpp"
#include "scene/units.hpp"

namespace palpate {

/// Description of an outcome.
struct OutcomeInfo {
  std::string name;
  std::string kind;  ///< the key of its definition, such as "displacement"
  Dimension dimension{};
  bool degrees = false;     ///< the value is an angle, without dimension
  bool has_vector = false;  ///< it has three components besides the value
};

/// The value of an outcome at a time, in the units of the scene.
struct OutcomeValue {
  double value = 0.0;
  /// Displacements, rotations and forces also have components; their `value` is the length, or the component
  /// along the direction that the scene gives.
  std::optional<Vec3> vector{};
};

/// Computes the outcomes of a scene.
class OutcomeProbe {
 public:
  /// Throws Error naming the scene and the key path if a position is outside its body. O(tets x positions).
  OutcomeProbe(const Scene& scene, const Bodies& bodies);

  [[nodiscard]] const std::vector<OutcomeInfo>& infos() const { return infos_; }
  /// The values in the scene's order. Displacements and rotations are relative to bodies at rest, also for
  /// bodies that are absent. O(tets of the bodies concerned, log).
  [[nodiscard]] std::vector<OutcomeValue> values(const Simulation& simulation) const;
  /// The unit of an outcome in the scene's units: "mm", "deg".
  [[nodiscard]] std::string unit(std::size_t outcome) const;
  /// A value as text: "1.83 mm", "0.41 ml", "2.5 deg".
  [[nodiscard]] std::string in_words(std::size_t outcome, double value) const;

 private:
  /// An outcome with resolved names: bodies by number, material points by tet.
  struct Of {
    std::array<Index, 2> bodies{-1, -1};
    std::array<Landmark, 2> marks{};
    std::vector<HalfSpace> spaces{};
    Cavity cavity{};
    std::optional<Vec3> direction{};  ///< unit
  };
  friend struct OutcomeReader;
  friend struct OutcomeTeller;
  Units units_;
  std::vector<SceneOutcome> outcomes_;
  std::vector<OutcomeInfo> infos_;
  std::vector<Of> of_;
};

}  // namespace palpate
