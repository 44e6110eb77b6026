#pragma once

#include <span>

#include <palpate/types.hpp>

namespace palpate::fem {

/// Forces on points in a step, N, and pressures on whole bodies.
struct ExternalForces {
  std::span<const Vec3> all;  ///< (n_points x 3), or empty
  /// (n_points x 3) those of `all` that turn with a body within the step (pressures), or empty. Where a body
  /// is solved in a rotated frame they rotate with it. Without that, a pressure on a closed surface would
  /// have a torque. They are for Dynamics::deformed_positions().
  std::span<const Vec3> turning;
  /// (n_bodies) ambient pressures (Elements::set_ambient), Pa, or empty. They are part of the forces of the
  /// tissue, as of the end of the step, and not of `all`.
  std::span<const double> ambient;
};

}  // namespace palpate::fem
