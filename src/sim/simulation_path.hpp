#pragma once

#include <span>
#include <vector>

#include <palpate/simulation.hpp>

namespace palpate {

/// The positions through which a step led, for tests of what passes within it: a step may be divided, and a
/// straight line from its start to its end then says nothing.
class SimulationPath {
 public:
  /// Records the path of each step from now on, until the model is changed.
  static void record(Simulation& simulation);
  /// Positions at the end of each substep of the last step (n_substeps of (n_points x 3)), m. Valid until the
  /// next step; empty if it is not recorded.
  [[nodiscard]] static std::span<const std::vector<Vec3>> of_last_step(const Simulation& simulation);
};

}  // namespace palpate
