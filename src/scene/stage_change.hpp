#pragma once

#include <span>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// What the stages of a scene change, as a simulation takes it; all names and selections are found at once,
/// so that a stage cannot fail for them after hours.
class StageChanges {
 public:
  /// \param bodies  at rest, those of the scene. Throws Error naming the scene and the key path: a selection
  /// of no point, a body removed that is not there, a rigid body without a material released, one that tissue
  /// is attached to released or removed, a motion that does not start where the body is. O(points x
  /// selections).
  StageChanges(const Scene& scene, const Bodies& bodies);

  /// The changes of a stage that starts now.
  /// \param positions  (n_points x 3) now
  /// \param ties       of the simulation, now
  [[nodiscard]] ModelChange at_start(std::size_t stage, const Bodies& bodies, std::span<const Vec3> positions,
                                     std::span<const Tie> ties, double time) const;
  /// Gravity while a stage runs: the last that was set, or that of the scene.
  [[nodiscard]] Vec3 gravity(std::size_t stage) const;

 private:
  struct WantedTie {
    Index point = -1;
    Index to = -1;
    std::optional<double> stiffness{};
  };
  /// Times count from the start of the stage; of ties what they are of.
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
