#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>

namespace palpate::view {

/// The largest force with which a point of tissue may be pulled: more would invert tets or throw bodies away.
/// It is the least of
/// - the force that stretches the tissue around the point by about a fifth of its own size: largest_strain
///   times a third of Young's modulus times area, of the surface triangles there or, at corners less, of the
///   faces opposite the point in its tets,
/// - the force that presses the whole body into the softest body near it (their boxes meet): largest_squeeze
///   times Young's modulus of that times a quarter of the body's surface, a ball's cross-section,
/// - for a free body (no point fixed, prescribed or tied), the force that moves all of it by largest_leap
/// mean
///   edges within a time step from rest.
class PullLimits {
 public:
  static constexpr double largest_strain = 0.2;
  static constexpr double largest_squeeze = 0.1;
  static constexpr double largest_leap = 0.2;  ///< like prescribed bodies that are moved by hand

  /// \param of_bodies  (n_bodies) mean material of each
  /// \param edges      (n_bodies) mean length of an edge
  ///
  /// O(points + triangles + tets + bodies^2).
  PullLimits(const Model& model, std::span<const Material> of_bodies, std::span<const double> edges,
             double time_step);

  /// The largest force of a pull, in the unit of the scene; 0 at a point inside.
  [[nodiscard]] double force(Index point) const { return forces_[static_cast<std::size_t>(point)]; }
  [[nodiscard]] double mass(Index point) const { return masses_[static_cast<std::size_t>(point)]; }

 private:
  std::vector<double> masses_;  ///< (n_points)
  std::vector<double> forces_;  ///< (n_points)
};

/// A spring whose damper is critical for the mass of its point, as Simulation::grab() makes it.
struct PullSpring {
  double stiffness = 0.0;  ///< wanted stiffness
  double mass = 0.0;       ///< of the point
  double most = 0.0;       ///< largest force of spring and damper together
};

/// The stiffness with which spring and damper pull no harder than `most` at the start of a step, and at the
/// predicted position at its end: at most that of the spring. The spring is softened, and its target stays;
/// so a hand far away pulls with about `most` during the whole step.
[[nodiscard]] double limited_stiffness(const PullSpring& spring, const Vec3& point, const Vec3& velocity,
                                       double time_step, const Vec3& target);

}  // namespace palpate::view
