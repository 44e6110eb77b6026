#pragma once

#include <span>

#include <palpate/types.hpp>

namespace palpate::fem {

/// Forces on points in a step, N.
struct ExternalForces {
  std::span<const Vec3> all;  ///< (n_points x 3), or empty
  /// (n_points x 3) those of `all` that turn with a body within the step (pressures), or empty. Where a body
  /// is solved in a rotated frame they rotate with it. Without that, a pressure on a closed surface would
  /// have a torque. They are for Dynamics::deformed_positions().
  std::span<const Vec3> turning;
};

}  // namespace palpate::fem
