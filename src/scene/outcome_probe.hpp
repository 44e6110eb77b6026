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

/// What an outcome is of.
struct OutcomeInfo {
  std::string name;
  std::string kind;  ///< "displacement": the key of its definition
  Dimension dimension{};
  bool degrees = false;     ///< an angle; has no dimension
  bool has_vector = false;  ///< three components besides the value
};

/// An outcome at a moment, in the units of the scene.
struct OutcomeValue {
  double value = 0.0;
  std::optional<Vec3> vector{};  ///< of displacements, rotations and forces: all of it, along x, y and z
};

/// Works out the outcomes of a scene.
class OutcomeProbe {
 public:
  /// Throws Error naming the scene and the key path where a place is outside of its body. O(tets x places).
  OutcomeProbe(const Scene& scene, const Bodies& bodies);

  [[nodiscard]] const std::vector<OutcomeInfo>& infos() const { return infos_; }
  /// In the scene's order. Displacements and rotations are from the bodies at rest; of a body that is not
  /// there they are those where it is. O(tets of the bodies they are of, log).
  [[nodiscard]] std::vector<OutcomeValue> values(const Simulation& simulation) const;
  /// The unit of an outcome in the scene's units: "mm", "deg".
  [[nodiscard]] std::string unit(std::size_t outcome) const;
  /// A value for people: "1.83 mm", "0.41 ml", "2.5 deg".
  [[nodiscard]] std::string in_words(std::size_t outcome, double value) const;

 private:
  /// Resolved once: bodies by number, places by tet.
  struct Of {
    std::array<Index, 2> bodies{-1, -1};
    std::array<Landmark, 2> marks{};
    std::vector<HalfSpace> spaces{};
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
