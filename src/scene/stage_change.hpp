#pragma once

#include <span>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// The changes of the stages of a scene, in the form that a simulation needs. All names and selections are
/// resolved at the start, so that a stage cannot fail because of them after hours.
class StageChanges {
 public:
  /// Throws Error naming the scene and the key path: for an empty selection, the removal of an absent body,
  /// the release of a rigid body without a material, the release or removal of a body to which tissue is
  /// attached, and a motion that does not start at the body's place. O(points x selections).
  /// \param bodies  the scene's bodies at rest
  StageChanges(const Scene& scene, const Bodies& bodies);

  /// The changes at the start of a stage.
  /// \param positions  (n_points x 3), current
  /// \param ties       the current ones of the simulation
  [[nodiscard]] ModelChange at_start(std::size_t stage, const Bodies& bodies, std::span<const Vec3> positions,
                                     std::span<const Tie> ties, double time) const;
  /// Gravity during a stage: the last value that a stage has set, or that of the scene.
  [[nodiscard]] Vec3 gravity(std::size_t stage) const;

 private:
  struct WantedTie {
    Index point = -1;
    Index to = -1;
    std::optional<double> stiffness{};
  };
  /// The changes of a stage before positions are known: times count from its start, and ties have no position
  /// yet.
  struct Changes {
    ModelChange fixed;
    std::vector<WantedTie> ties;
    std::vector<std::array<Index, 2>> cuts;
    Vec3 gravity{};
  };
  friend class StageReader;
  std::vector<Changes> changes_;
};

}  // namespace palpate
